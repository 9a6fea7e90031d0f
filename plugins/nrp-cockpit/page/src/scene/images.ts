import { type MeshLambertMaterial, RepeatWrapping, SRGBColorSpace, Texture } from "three";
import type { Shape } from "../world/entities";
import { GLB_TYPE, texturedMesh } from "../world/glb";
import { contentOf } from "./content";

/** Names the image on a mesh and its tint by their contents; null if it has none. */
export function keyOfImage(mesh: Shape["mesh"]): string | null {
  const textured = mesh?.type === GLB_TYPE ? texturedMesh(mesh.data) : null;
  return textured && `${contentOf(textured.image.data)} ${textured.tint}`;
}

/** Puts the image of a file on a material as soon as it is decoded; until then it has its mean colour. */
export function imageOn(material: MeshLambertMaterial, data: Uint8Array, onImage: () => void): void {
  const mesh = texturedMesh(data);
  if (!mesh) return;
  let gone = false;
  material.addEventListener("dispose", () => {
    gone = true;
  });
  createImageBitmap(new Blob([mesh.image.data], { type: mesh.image.type }))
    .then((image) => {
      if (gone) return image.close();
      const map = new Texture(image);
      map.colorSpace = SRGBColorSpace;
      map.wrapS = map.wrapT = RepeatWrapping;
      map.flipY = false; // glTF counts from the top
      map.anisotropy = 4;
      map.needsUpdate = true;
      material.map = map;
      material.color.setRGB(...mesh.tint);
      material.needsUpdate = true;
      onImage();
    })
    .catch(() => undefined); // a damaged image: the mean colour stays
}
