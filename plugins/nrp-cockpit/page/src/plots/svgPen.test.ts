// @vitest-environment happy-dom
import { expect, test } from "vitest";
import { SvgPen } from "./svgPen";

test("lines that look alike become one path, and what is saved comes back", () => {
  const pen = new SvgPen("10px Arial");
  pen.save();
  pen.translate(100, 50);
  pen.strokeStyle = "#ff0000";
  for (const x of [1, 2.004]) {
    pen.beginPath();
    pen.moveTo(x, 0);
    pen.lineTo(x, 5);
    pen.stroke();
  }
  pen.restore();
  pen.fillRect(0, 0, 2, 1);
  expect(pen.drawn.split("\n")).toEqual([
    expect.stringContaining('d="M101 50L101 55M102 50L102 55" fill="none" stroke="#ff0000"'),
    '<path d="M0 0L2 0L2 1L0 1Z" fill="#000000"/>',
  ]);
});

test("words are text with a plain baseline, and colours have an opacity of their own", () => {
  const pen = new SvgPen("10px Arial");
  pen.fillStyle = "rgb(1 2 3 / 0.5)";
  pen.textAlign = "right";
  pen.textBaseline = "middle";
  pen.fillText("a < b & c", 20, 30);
  expect(pen.drawn).toBe(
    '<text x="20" y="33.5" text-anchor="end" fill="rgb(1,2,3)" fill-opacity="0.5">a &lt; b &amp; c</text>',
  );
});

test("a turned word stands on its turned baseline", () => {
  const pen = new SvgPen("10px Arial");
  pen.translate(7, 40);
  pen.rotate(-Math.PI / 2);
  pen.textBaseline = "middle";
  pen.fillText("up", 0, 0);
  expect(pen.drawn).toContain('transform="matrix(0 -1 1 0 10.5 40)"');
});
