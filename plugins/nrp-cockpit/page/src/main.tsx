import { lazy, StrictMode, Suspense } from "react";
import { createRoot } from "react-dom/client";
import { followComparison } from "./difference/comparison";
import { Root } from "./Root";
import { followRun } from "./state/run";
import { followStart } from "./state/start";
import { followLength } from "./state/timeWindow";
import { followView, isEmbedded } from "./state/view";
import { followSweep } from "./sweep/store";
import "./ui/tokens.css";
import "./ui/base.css";
import "./ui/controls.css";
import "./ui/panel.css";
import { Boundary } from "./ui/Boundary";
import { wire } from "./wire";

const EmbeddedView = lazy(() => import("./compare/EmbeddedView"));

const root = document.getElementById("root");
if (!root) throw new Error("index.html has no element 'root'");
followView();
followRun();
followComparison();
followStart();
followLength();
followSweep();
wire.open();
const inside = isEmbedded(window.location);
createRoot(root).render(
  <StrictMode>
    <Boundary title="Error">
      {inside ? (
        <Suspense fallback={null}>
          <EmbeddedView />
        </Suspense>
      ) : (
        <Root />
      )}
    </Boundary>
  </StrictMode>,
);
