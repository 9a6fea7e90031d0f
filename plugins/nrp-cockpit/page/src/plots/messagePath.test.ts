import { describe, expect, test } from "vitest";
import { numericPaths, readerOf } from "./messagePath";

const TWIST = `geometry_msgs/Vector3 linear
geometry_msgs/Vector3 angular
================================================================================
MSG: geometry_msgs/Vector3
float64 x
float64 y
float64 z`;

const JOINTS = `std_msgs/Header header
uint8 KIND=3
string[] name
float64[] position
float64[36] covariance
bool[2] ready
================================================================================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
================================================================================
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec`;

describe("the paths of a type", () => {
  test("lead through nested types", () => {
    expect(numericPaths(TWIST)).toEqual(
      ["linear", "angular"].flatMap((field) => ["x", "y", "z"].map((axis) => `${field}.${axis}`)),
    );
  });

  test("leave out headers, texts, constants and long arrays", () => {
    expect(numericPaths(JOINTS)).toEqual(["position[0]", "ready[0]", "ready[1]"]);
  });

  test("offer as many elements of an open array as it is said to have", () => {
    expect(numericPaths(JOINTS, () => 3)).toContain("position[2]");
  });
});

describe("a message path", () => {
  test("reads fields, elements, large integers and truths", () => {
    expect(readerOf("linear.x")({ linear: { x: 2.5 } })).toBe(2.5);
    expect(readerOf("points[1].y")({ points: [{ y: 1 }, { y: 7 }] })).toBe(7);
    expect(readerOf("data[2]")({ data: new Float64Array([1, 2, 3]) })).toBe(3);
    expect(readerOf("data")({ data: 12n })).toBe(12);
    expect(readerOf("data")({ data: true })).toBe(1);
  });

  test("finds nothing where a message has no such number", () => {
    expect(readerOf("linear.x.z")({})).toBeUndefined();
    expect(readerOf("data[5]")({ data: [1] })).toBeUndefined();
    expect(readerOf("name")({ name: "husky" })).toBeUndefined();
  });
});
