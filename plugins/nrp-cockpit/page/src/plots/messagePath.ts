import { parse } from "@foxglove/rosmsg";

/** Reads a number from a message; undefined where there is none. */
export type Read = (message: unknown) => number | undefined;

const STEP = /([^.[\]]+)|\[(\d+)\]/g;

/** How a message path such as `linear.x` or `data[3]` reads its number; true is 1, and false 0. */
export function readerOf(path: string): Read {
  const steps = [...path.matchAll(STEP)].map(([, name, index]) => name ?? Number(index));
  return (message) => {
    let value = message;
    for (const step of steps) value = (value as Record<string | number, unknown> | undefined)?.[step];
    return numberOf(value);
  };
}

function numberOf(value: unknown): number | undefined {
  if (typeof value === "number") return value;
  return typeof value === "bigint" || typeof value === "boolean" ? Number(value) : undefined;
}

type Definitions = ReturnType<typeof parse>;
type Field = Definitions[number]["definitions"][number];

const NOT_NUMBERS = new Set(["string", "wstring", "time", "duration"]);
/** Longer arrays of a fixed length, such as covariances, are not offered number by number. */
const LONGEST = 16;

/**
 * The paths of the numbers in a type, which is defined in the language of ROS 2 messages. `lengthOf` says how many
 * elements to offer of an array whose length is not fixed.
 */
export function numericPaths(schema: string, lengthOf: (path: string) => number = () => 1): string[] {
  const definitions = parse(schema, { ros2: true });
  const pathsOf = (fields: readonly Field[], prefix: string): string[] =>
    fields
      .filter(({ isConstant, name }) => !isConstant && name !== "header")
      .flatMap((field) =>
        placesOf(field, prefix + field.name, lengthOf).flatMap((path) => {
          if (field.isComplex) return pathsOf(fieldsOf(definitions, field.type), `${path}.`);
          return NOT_NUMBERS.has(field.type) ? [] : [path];
        }),
      );
  const root = definitions.find(({ name }) => name === undefined) ?? definitions[0];
  return pathsOf(root?.definitions ?? [], "");
}

const fieldsOf = (definitions: Definitions, type: string): readonly Field[] =>
  definitions.find(({ name }) => name === type)?.definitions ?? [];

function placesOf(field: Field, path: string, lengthOf: (path: string) => number): string[] {
  if (!field.isArray) return [path];
  const length = field.arrayLength ?? lengthOf(path);
  return length > LONGEST ? [] : Array.from({ length }, (_, index) => `${path}[${index}]`);
}
