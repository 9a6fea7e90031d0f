import { lazy, Suspense } from "react";
import { App } from "./App";
import { useStart } from "./state/start";
import { useSweep } from "./sweep/store";

const StartPage = lazy(() => import("./start/StartPage"));
const SweepPage = lazy(() => import("./sweep/SweepPage"));

/** The page of a run, or of a sweep or of all that can be opened if that is what the server shows. */
export function Root() {
  const start = useStart((state) => state.isOpen);
  const sweep = useSweep((state) => state.isOpen);
  if (!start && !sweep) return <App />;
  return <Suspense fallback={null}>{start ? <StartPage /> : <SweepPage />}</Suspense>;
}
