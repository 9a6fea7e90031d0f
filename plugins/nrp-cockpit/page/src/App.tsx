import { lazy, type ReactNode, Suspense } from "react";
import { useKeys } from "./keys/useKeys";
import { CockpitView } from "./layout/CockpitView";
import { HelpMap } from "./shell/HelpMap";
import { Notices } from "./shell/Notices";
import { Rail } from "./shell/Rail";
import { StatusBar } from "./shell/StatusBar";
import { useView, type View } from "./state/view";
import { Toolbar } from "./toolbar/Toolbar";
import { Boundary } from "./ui/Boundary";
import "./shell/shell.css";

const FunctionsView = lazy(() => import("./functions/FunctionsView"));
const DesignerView = lazy(() => import("./designer/DesignerView"));
const CompareView = lazy(() => import("./compare/CompareView"));

const views: Record<View, () => ReactNode> = {
  cockpit: () => <CockpitView />,
  functions: () => <FunctionsView />,
  designer: () => <DesignerView />,
  compare: () => <CompareView />,
};

/** The whole page: rail, toolbar, the open view, status bar. */
export function App() {
  const view = useView((state) => state.view);
  const help = useView((state) => state.help);
  useKeys();
  return (
    <div className="app">
      <a className="skip" href="#main">
        Skip to content
      </a>
      <Rail />
      <Toolbar />
      <main id="main" className="main" tabIndex={-1}>
        <Boundary key={view} title="Error">
          <Suspense fallback={null}>{views[view]()}</Suspense>
        </Boundary>
      </main>
      <StatusBar />
      <Notices />
      {help && <HelpMap />}
    </div>
  );
}
