import { readdirSync, readFileSync } from "node:fs";
import { dirname, join } from "node:path/posix";
import { expect, it } from "vitest";

type Graph = ReadonlyMap<string, ReadonlySet<string>>;

const SRC = join(import.meta.dirname, "");
const IMPORT = /(?:from|import)\s*\(?\s*"(\.[^"]+)"/g;

/** The files of the page, each with those that it imports, types included. */
function filesOfPage(): Graph {
  const names = readdirSync(SRC, { recursive: true, encoding: "utf8" });
  const files = new Set(names.filter((name) => /(?<!\.test)\.tsx?$/.test(name)));
  const imported = (name: string) =>
    [...readFileSync(join(SRC, name), "utf8").matchAll(IMPORT)].flatMap(([, path = ""]) => {
      const at = join(dirname(name), path);
      return [`${at}.ts`, `${at}.tsx`, join(at, "index.ts")].filter((one) => files.has(one));
    });
  return new Map([...files].map((name) => [name, new Set(imported(name))]));
}

/** The folders below `src`, each with those that its files import; files outside of a folder join the folders. */
function foldersOf(files: Graph): Graph {
  const found = new Map<string, Set<string>>();
  const folderOf = (name: string) => name.split("/", 1)[0] ?? "";
  for (const [name, others] of files) {
    const folder = folderOf(name);
    const known = found.get(folder) ?? new Set();
    for (const other of others) if (folderOf(other) !== folder) known.add(folderOf(other));
    found.set(folder, known);
  }
  return found;
}

/** What is in a circle, or between two: all that is left when what imports nothing more is taken away. */
function circlesOf(graph: Graph): string[] {
  const left = new Map([...graph].map(([name, others]) => [name, new Set(others)]));
  for (let before = -1; before !== left.size; ) {
    before = left.size;
    for (const [name, others] of left) if (![...others].some((one) => left.has(one))) left.delete(name);
  }
  return [...left].map(([name, others]) => `${name} imports ${[...others].filter((one) => left.has(one))}`);
}

it("no file and no folder of the page imports itself through others", () => {
  const files = filesOfPage();
  expect(files.size).toBeGreaterThan(200);
  expect(circlesOf(files)).toEqual([]);
  expect(circlesOf(foldersOf(files))).toEqual([]);
});

it("a circle is found, and what merely imports from it is not blamed for more", () => {
  const graph = new Map(
    Object.entries({ a: ["b"], b: ["c"], c: ["b"], d: [] }).map(([k, v]) => [k, new Set(v)]),
  );
  expect(circlesOf(graph)).toEqual(["a imports b", "b imports c", "c imports b"]);
});
