import { StrictMode } from "react";
import { createRoot } from "react-dom/client";
import { App } from "./App";
import { followRun } from "./state/run";
import { followView } from "./state/view";
import "./ui/tokens.css";
import "./ui/base.css";
import "./ui/controls.css";
import "./ui/panel.css";
import { wire } from "./wire";

const root = document.getElementById("root");
if (!root) throw new Error("index.html has no element 'root'");
followView();
followRun();
wire.open();
createRoot(root).render(
  <StrictMode>
    <App />
  </StrictMode>,
);
