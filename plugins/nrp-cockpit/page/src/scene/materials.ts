import { type Material, MeshLambertMaterial, SRGBColorSpace } from "three";
import type { Shape } from "../world/entities";
import type { Rgba } from "../world/messages";
import { imageOn, keyOfImage } from "./images";

/** One material for each colour and each image of the scene, however many bodies have it. */
export class Materials {
  private readonly byLook = new Map<string, MeshLambertMaterial>();

  /** `onImage` is called when an image, which takes a moment to decode, can be seen. */
  constructor(private readonly onImage: () => void = () => {}) {}

  of({ color, mesh }: Pick<Shape, "color" | "mesh">): Material {
    const image = keyOfImage(mesh);
    const key = `${color.r},${color.g},${color.b},${color.a},${image ?? ""}`;
    let material = this.byLook.get(key);
    if (!material) {
      material = made(color);
      this.byLook.set(key, material);
      if (image !== null && mesh) imageOn(material, mesh.data, this.onImage);
    }
    return material;
  }

  /** Frees all but these, so that a colour that changes all the time leaves nothing behind. */
  keepOnly(used: ReadonlySet<Material>): void {
    for (const [key, material] of this.byLook) {
      if (used.has(material)) continue;
      free(material);
      this.byLook.delete(key);
    }
  }

  dispose(): void {
    for (const material of this.byLook.values()) free(material);
    this.byLook.clear();
  }
}

function made({ r, g, b, a }: Rgba): MeshLambertMaterial {
  const material = new MeshLambertMaterial({ transparent: a < 1, opacity: a, depthWrite: a >= 1 });
  material.color.setRGB(r, g, b, SRGBColorSpace);
  return material;
}

function free(material: MeshLambertMaterial): void {
  material.map?.dispose();
  material.dispose();
}
