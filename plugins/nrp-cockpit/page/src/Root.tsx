import { lazy, Suspense } from "react";
import { App } from "./App";
import { useSweep } from "./sweep/store";

const SweepPage = lazy(() => import("./sweep/SweepPage"));

/** The page of a run, or of a sweep if that is what the server shows. */
export function Root() {
  if (!useSweep((state) => state.isOpen)) return <App />;
  return (
    <Suspense fallback={null}>
      <SweepPage />
    </Suspense>
  );
}
