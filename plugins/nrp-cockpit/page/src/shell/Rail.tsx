import { LayoutMenu } from "../layout/LayoutMenu";
import { leave, useStart } from "../state/start";
import { setHelp, toggleTheme, useView, VIEWS, type View } from "../state/view";
import { Icon } from "../ui/Icon";
import { Menu } from "../ui/Menu";

const names: Record<View, string> = {
  cockpit: "Cockpit",
  functions: "Functions",
  designer: "Designer",
  compare: "Compare",
};

/** The views at the left edge; theme and help at its foot. Without views there are no keys to help with. */
export function Rail({ views = VIEWS }: { views?: readonly View[] }) {
  const open = useView((state) => state.view);
  return (
    <nav className="rail" aria-label="Views">
      <Home />
      {views.map((view) => (
        <a key={view} href={`#/${view}`} aria-current={view === open ? "page" : undefined}>
          <Icon name={view} />
          {names[view]}
        </a>
      ))}
      <span className="grow" />
      {views.length > 0 && open === "cockpit" && <LayoutMenu />}
      <button type="button" aria-label="Switch between light and dark" onClick={toggleTheme}>
        <Icon name="theme" />
        Theme
      </button>
      {views.length > 0 && (
        <button type="button" aria-label="Help and keyboard map (?)" onClick={() => setHelp(true)}>
          <Icon name="help" />
          Help
        </button>
      )}
    </nav>
  );
}

/** The sign of the project, which leads to the start page if the server has one. */
function Home() {
  const canLeave = useStart(({ start, isOpen }) => start !== null && !isOpen);
  const logo = (
    <svg className="rail-logo" viewBox="0 0 32 32" aria-hidden="true" fill="none" stroke="currentColor">
      <g strokeWidth="2.5" strokeLinecap="round">
        <path d="M26 10A11.500 11.500 0 0 0 5.200 12M6 22a11.500 11.500 0 0 0 20.800-2" />
        <circle cx="16" cy="16" r="3.500" fill="currentColor" />
        <path d="m26.500 4.500-.3 5.700-5.600-.6M5.500 27.500l.3-5.700 5.600.6" />
      </g>
    </svg>
  );
  if (!canLeave) return logo;
  const item = { label: "Close this and open another", onSelect: () => void leave() };
  return (
    <Menu label="Start page" items={[item]} className="">
      {logo}
    </Menu>
  );
}
