import { create } from "zustand";
import { download } from "./download";

const FRAMES_HZ = 30;

/** The canvas that is filmed. */
export const useFilm = create<{ recorder: MediaRecorder | null }>(() => ({ recorder: null }));

/** Films a canvas until {@link endFilm}, then has the browser save the video. */
export function startFilm(canvas: HTMLCanvasElement, name: string): void {
  const recorder = new MediaRecorder(canvas.captureStream(FRAMES_HZ), { mimeType: "video/webm" });
  const parts: Blob[] = [];
  recorder.ondataavailable = ({ data }) => parts.push(data);
  recorder.onstop = () => download(`${name}.webm`, new Blob(parts, { type: "video/webm" }));
  recorder.start();
  useFilm.setState({ recorder });
}

export function endFilm(): void {
  useFilm.getState().recorder?.stop();
  useFilm.setState({ recorder: null });
}
