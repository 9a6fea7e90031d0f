import { useCallback, useEffect, useRef } from "react";

/** Draws after every render and, at most once a frame, whenever the returned function is called. */
export function useFrame(draw: () => void): () => void {
  const drawing = useRef(draw);
  const frame = useRef(0);
  const redraw = useCallback(() => {
    frame.current ||= requestAnimationFrame(() => {
      frame.current = 0;
      drawing.current();
    });
  }, []);
  useEffect(() => {
    drawing.current = draw;
    redraw();
  });
  useEffect(
    () => () => {
      cancelAnimationFrame(frame.current);
      frame.current = 0;
    },
    [],
  );
  return redraw;
}
