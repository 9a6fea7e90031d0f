import { type Material, MeshLambertMaterial, SRGBColorSpace } from "three";
import type { Rgba } from "../world/messages";

/** One material for each colour of the scene, however many bodies have it. */
export class Materials {
  private readonly byColor = new Map<string, Material>();

  of(color: Rgba): Material {
    const key = `${color.r},${color.g},${color.b},${color.a}`;
    let material = this.byColor.get(key);
    if (!material) {
      material = made(color);
      this.byColor.set(key, material);
    }
    return material;
  }

  /** Frees all but these, so that a colour that changes all the time leaves nothing behind. */
  keepOnly(used: ReadonlySet<Material>): void {
    for (const [key, material] of this.byColor) {
      if (used.has(material)) continue;
      material.dispose();
      this.byColor.delete(key);
    }
  }

  dispose(): void {
    for (const material of this.byColor.values()) material.dispose();
    this.byColor.clear();
  }
}

function made({ r, g, b, a }: Rgba): Material {
  const material = new MeshLambertMaterial({ transparent: a < 1, opacity: a, depthWrite: a >= 1 });
  material.color.setRGB(r, g, b, SRGBColorSpace);
  return material;
}
