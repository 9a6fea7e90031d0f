/**
 * A canvas's WebGL, and whether a graphics card draws: shadows and smooth edges are too slow without one. A browser
 * that would draw on the processor refuses the first request at once.
 */
export function drawingOn(canvas: HTMLCanvasElement): { context: WebGL2RenderingContext; fine: boolean } {
  const wanted = { alpha: true, stencil: true, depth: true, premultipliedAlpha: true };
  const quick = { ...wanted, antialias: true, failIfMajorPerformanceCaveat: true };
  const context = canvas.getContext("webgl2", quick) as WebGL2RenderingContext | null;
  if (context && !isSoftware(context)) return { context, fine: true };
  const plain = { ...wanted, antialias: false };
  const slow = context ?? (canvas.getContext("webgl2", plain) as WebGL2RenderingContext | null);
  if (!slow) throw new Error("no WebGL 2");
  return { context: slow, fine: false };
}

/** Some drivers on the processor do not say so when they are asked for a context. */
function isSoftware(gl: WebGL2RenderingContext): boolean {
  const info = gl.getExtension("WEBGL_debug_renderer_info");
  const name = info ? String(gl.getParameter(info.UNMASKED_RENDERER_WEBGL)) : "";
  return /swiftshader|llvmpipe|software|basic render/i.test(name);
}
