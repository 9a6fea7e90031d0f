import { describe, expect, it } from "vitest";
import { bodyOf, type Entities, updated } from "./entities";
import type { SceneEntity } from "./messages";

const pose = { position: { x: 0, y: 0, z: 0 }, orientation: { x: 0, y: 0, z: 0, w: 1 } };
const red = { r: 1, g: 0, b: 0, a: 1 };

const box = (id: string, frame_id = "world"): SceneEntity => ({
  id,
  frame_id,
  cubes: [{ pose, size: { x: 1, y: 2, z: 3 }, color: red }],
  spheres: [],
  cylinders: [],
  models: [],
});

const none: Entities = new Map();
const both = updated(none, {
  deletions: [],
  entities: [box("room/wall/a"), box("husky/base/b", "husky/base")],
});

describe("the entities of a scene", () => {
  it("are known with their body, frame and shapes", () => {
    const entity = both.get("husky/base/b");
    expect(entity).toMatchObject({ body: "husky", frame: "husky/base" });
    expect(entity?.shapes).toMatchObject([{ kind: "cube", size: [1, 2, 3], color: red }]);
  });

  it("stay the same objects when an update does not name them", () => {
    const after = updated(both, { deletions: [], entities: [box("room/wall/a")] });
    expect(after.get("husky/base/b")).toBe(both.get("husky/base/b"));
    expect(after.get("room/wall/a")).not.toBe(both.get("room/wall/a"));
  });

  it("go one by one, or all at once before new ones come", () => {
    const one = updated(both, { deletions: [{ type: 0, id: "room/wall/a" }], entities: [] });
    expect([...one.keys()]).toEqual(["husky/base/b"]);
    const all = updated(both, { deletions: [{ type: 1, id: "" }], entities: [box("new/link/c")] });
    expect([...all.keys()]).toEqual(["new/link/c"]);
  });

  it("keep the file of a mesh and its factors", () => {
    const data = new Uint8Array([1, 2]);
    const model = { pose, scale: { x: 1, y: 1, z: -1 }, color: red, media_type: "model/stl", data };
    const entity: SceneEntity = { ...box("a/b/c"), cubes: [], models: [model] };
    const [shape] = updated(none, { deletions: [], entities: [entity] }).get("a/b/c")?.shapes ?? [];
    expect(shape).toMatchObject({ kind: "mesh", size: [1, 1, -1], mesh: { data, type: "model/stl" } });
  });

  it("belong to the model that their path begins with", () => {
    expect(bodyOf("husky/base_link/cover")).toBe("husky");
    expect(bodyOf("husky")).toBe("husky");
  });
});
