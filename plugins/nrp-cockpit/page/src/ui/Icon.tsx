import { paths } from "./icons";

export type IconName = keyof typeof paths;

/** A 16 px line icon; decoration only, so the control around it carries the name. */
export function Icon({ name, small = false }: { name: IconName; small?: boolean }) {
  return (
    <svg className={small ? "icon icon-small" : "icon"} viewBox="0 0 16 16" aria-hidden="true">
      {paths[name]}
    </svg>
  );
}
