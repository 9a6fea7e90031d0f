import { dismiss, useNotices } from "../state/notices";
import { IconButton } from "../ui/Button";
import { Icon } from "../ui/Icon";

/** The last few sentences that the page has to say, for some seconds each. */
export function Notices() {
  const notices = useNotices((state) => state.notices);
  return (
    <div className="notices" aria-live="polite">
      {notices.map(({ id, weight, text }) => (
        <div key={id} className={`note note-${weight}`} role={weight === "bad" ? "alert" : undefined}>
          <Icon name={weight === "bad" ? "error" : "note"} />
          <p>{text}</p>
          <IconButton icon="close" label="Dismiss" kind="ghost" small onClick={() => dismiss(id)} />
        </div>
      ))}
    </div>
  );
}
