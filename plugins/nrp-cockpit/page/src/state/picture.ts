import { startTransition, useEffect, useState } from "react";
import { create } from "zustand";

/** Whether the room was drawn for the first time, or cannot be. */
const usePicture = create(() => ({ drawn: false }));

/** After this time nothing waits for the room any more. */
const PATIENCE_MS = 2000;

/** The mark in the browser's own record of times at which the room is seen first. */
const FIRST_PICTURE = "first-picture";
let marked = false;

export function pictureDrawn(): void {
  if (!marked) performance.mark(FIRST_PICTURE);
  marked = true;
  waitNoLonger();
}

export function waitNoLonger(): void {
  if (!usePicture.getState().drawn) usePicture.setState({ drawn: true });
}

window.setTimeout(waitNoLonger, PATIENCE_MS);

/** Whether what may come after the first picture of the room comes now; it would delay that by half. */
export function useAfterPicture(): boolean {
  const [after, setAfter] = useState(usePicture.getState().drawn);
  useEffect(() => {
    const follow = () => startTransition(() => setAfter(usePicture.getState().drawn));
    follow();
    return usePicture.subscribe(follow);
  }, []);
  return after;
}
