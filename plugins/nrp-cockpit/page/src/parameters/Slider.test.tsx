// @vitest-environment happy-dom
import { cleanup, fireEvent, render, screen } from "@testing-library/react";
import { afterEach, expect, test, vi } from "vitest";
import type { ChangeableNumber } from "./numbers";
import { Slider } from "./Slider";

const rate: ChangeableNumber = { name: "RATE", value: 250, low: 0, high: 500, whole: false, note: "Hz" };
const show = (number: ChangeableNumber, onChange = vi.fn(async () => undefined), disabled = false) => {
  render(<Slider number={number} of="steer.py" disabled={disabled} onChange={onChange} />);
  return onChange;
};
const field = () => screen.getByRole<HTMLInputElement>("textbox", { name: "Value of RATE of steer.py" });
const slider = () => screen.getByRole<HTMLInputElement>("slider", { name: "RATE of steer.py" });

afterEach(cleanup);

test("a moved slider changes the number, and the field shows it", () => {
  const onChange = show(rate);
  expect(slider().getAttribute("aria-valuetext")).toBe("250 Hz");
  fireEvent.change(slider(), { target: { value: "125" } });
  expect(onChange).toHaveBeenCalledWith(125);
  expect(field().value).toBe("125");
});

test("a value beyond the slider is written into the field, and words are no value", () => {
  const onChange = show(rate);
  fireEvent.blur(field(), { target: { value: "9e3" } });
  expect(onChange).toHaveBeenLastCalledWith(9000);
  fireEvent.blur(field(), { target: { value: "fast" } });
  fireEvent.blur(field(), { target: { value: "" } });
  expect(onChange).toHaveBeenCalledTimes(1);
});

test("different values of cells are not shown as one number", () => {
  show({ ...rate, value: null });
  expect(field().value).toBe("");
  expect(field().placeholder).toBe("varies");
  expect(slider().getAttribute("aria-valuetext")).toBe("different values");
});

test("what cannot be steered is disabled", () => {
  show(rate, undefined, true);
  expect(slider().disabled).toBe(true);
  expect(field().disabled).toBe(true);
});
