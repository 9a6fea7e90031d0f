// @vitest-environment happy-dom
import { expect, it } from "vitest";
import { isEmbedded } from "../state/view";
import { embeddedAddress } from "./embedded";

it("shows a run inside the page with the page's own token", () => {
  const address = new URL(embeddedAddress({ pathname: "/", search: "?token=a%2Bb" }, "beside"), "http://x");
  expect([address.searchParams.get("token"), address.searchParams.get("run")]).toEqual(["a+b", "beside"]);
  expect([isEmbedded(address), isEmbedded({ search: "?token=a" })]).toEqual([true, false]);
});
