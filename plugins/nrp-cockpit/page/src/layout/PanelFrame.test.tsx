// @vitest-environment happy-dom
import { act, cleanup, render, screen } from "@testing-library/react";
import { lazy } from "react";
import { afterEach, expect, test } from "vitest";
import { waitNoLonger } from "../state/picture";
import { PanelFrame } from "./PanelFrame";
import { panels } from "./panels";

const { component } = panels.scene;

afterEach(() => {
  cleanup();
  panels.scene.component = component;
});

test("a panel that is still fetched has its place, without tools, and all around it stays", async () => {
  let arrive = () => {};
  const module = new Promise<{ default: () => string }>((resolve) => {
    arrive = () => resolve({ default: () => "the room" });
  });
  panels.scene.component = lazy(() => module);
  waitNoLonger();
  await act(async () => {
    render(
      <>
        <PanelFrame id="scene" />
        <p>the timeline</p>
      </>,
    );
  });
  expect(screen.getByRole("region", { name: "Scene" })).toBeTruthy();
  expect(screen.getByText("the timeline").style.display).toBe("");
  expect(screen.queryAllByRole("button")).toEqual([]);
  await act(async () => arrive());
  expect(screen.getByText("the room")).toBeTruthy();
});
