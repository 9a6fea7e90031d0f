import { lazy, type ReactNode, Suspense } from "react";
import { useKeys } from "./keys/useKeys";
import { CockpitView } from "./layout/CockpitView";
import { HelpMap } from "./shell/HelpMap";
import { Notices } from "./shell/Notices";
import { Rail } from "./shell/Rail";
import { StatusBar } from "./shell/StatusBar";
import { useRun } from "./state/run";
import { useView, type View } from "./state/view";
import { Toolbar } from "./toolbar/Toolbar";
import { Boundary } from "./ui/Boundary";
import { Empty, Panel } from "./ui/Panel";
import "./shell/narrow.css";
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
  const lost = useRun(({ link, experiment }) => link.state !== "open" && experiment !== null);
  const refused = useRun(({ link }) => (link.state === "refused" ? link.reason : null));
  useKeys();
  return (
    <div className="app">
      <a className="skip" href="#main">
        Skip to content
      </a>
      <Rail />
      <Toolbar />
      <main id="main" className="main" data-lost={lost || undefined} tabIndex={-1}>
        {refused ? (
          <Panel title="No access">
            <Empty>The server does not let this page in: {refused}.</Empty>
          </Panel>
        ) : (
          <Boundary key={view} title="Error">
            <Suspense fallback={null}>{views[view]()}</Suspense>
          </Boundary>
        )}
      </main>
      <StatusBar />
      <Notices />
      {help && <HelpMap />}
    </div>
  );
}
