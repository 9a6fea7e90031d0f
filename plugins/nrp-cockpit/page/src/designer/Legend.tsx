/** What the colours of wires and ends mean, by the kind of drawing. */
const MEANINGS = {
  functions: { message: "message", drives: "drives neurons", reads: "reads neurons", free: "free" },
  brain: { excites: "excites", inhibits: "inhibits" },
} as const;

export const Legend = ({ kind }: { kind: keyof typeof MEANINGS }) => (
  <p className="legend" aria-hidden="true">
    {Object.entries(MEANINGS[kind]).map(([look, meaning]) => (
      <span key={look}>
        <i className={`end-${look}`} /> {meaning}
      </span>
    ))}
  </p>
);
