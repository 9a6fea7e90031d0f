import {
  AlwaysStencilFunc,
  type Color,
  InstancedMesh,
  Mesh,
  MeshBasicMaterial,
  NotEqualStencilFunc,
  type Object3D,
  ReplaceStencilOp,
  ShaderMaterial,
  Vector2,
} from "three";

const WIDTH_PX = 3;
const DIRECTIONS = 8;

const vertex = /* glsl */ `
  uniform vec2 step;
  void main() {
    gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
    float angle = float(gl_InstanceID) * ${((2 * Math.PI) / DIRECTIONS).toFixed(6)};
    gl_Position.xy += step * vec2(cos(angle), sin(angle)) * gl_Position.w;
  }`;
const fragment = /* glsl */ `
  uniform vec3 color;
  void main() {
    gl_FragColor = vec4(color, 1.0);
    #include <colorspace_fragment>
  }`;

/**
 * A line of constant width around meshes, also where something hides them: their own pixels are marked in the
 * stencil, then they are drawn several times, shifted by the width of the line, outside of the marks.
 */
export class Outline {
  private readonly mark = new MeshBasicMaterial({
    colorWrite: false,
    depthWrite: false,
    depthTest: false,
    transparent: true, // drawn after the solid bodies
    stencilWrite: true,
    stencilRef: 1,
    stencilFunc: AlwaysStencilFunc,
    stencilZPass: ReplaceStencilOp,
  });
  private readonly line = new ShaderMaterial({
    vertexShader: vertex,
    fragmentShader: fragment,
    uniforms: { step: { value: new Vector2() }, color: { value: null as Color | null } },
    depthWrite: false,
    depthTest: false,
    transparent: true,
    stencilWrite: true,
    stencilRef: 1,
    stencilFunc: NotEqualStencilFunc,
  });
  private added: Object3D[] = [];

  /** Surrounds these meshes, and no others. */
  around(meshes: Iterable<Mesh>): void {
    this.clear();
    for (const mesh of meshes) {
      const marked = new Mesh(mesh.geometry, this.mark);
      const line = new InstancedMesh(mesh.geometry, this.line, DIRECTIONS);
      marked.renderOrder = 1;
      line.renderOrder = 2;
      line.frustumCulled = false;
      mesh.add(marked, line);
      this.added.push(marked, line);
    }
  }

  style(color: Color, width: number, height: number): void {
    const { step, color: uniform } = this.line.uniforms;
    if (!step || !uniform) return;
    uniform.value = color;
    step.value.set((2 * WIDTH_PX) / width, (2 * WIDTH_PX) / height);
  }

  dispose(): void {
    this.clear();
    this.mark.dispose();
    this.line.dispose();
  }

  private clear(): void {
    for (const object of this.added) {
      object.removeFromParent();
      if (object instanceof InstancedMesh) object.dispose();
    }
    this.added = [];
  }
}
