const WIDTH = 64;
const HEIGHT = 16;

/** The last times of a function, from zero to the longest of them. */
export function Sparkline({ values, label }: { values: readonly number[]; label: string }) {
  if (values.length < 2) return null;
  const longest = Math.max(...values);
  const points = values.map((value, at) => {
    const x = (at / (values.length - 1)) * WIDTH;
    const y = HEIGHT - 1 - (longest > 0 ? value / longest : 0) * (HEIGHT - 2);
    return `${x.toFixed(1)},${y.toFixed(1)}`;
  });
  return (
    <svg width={WIDTH} height={HEIGHT} role="img" aria-label={`${label}, at most ${longest.toFixed(2)} ms`}>
      <polyline points={points.join(" ")} className="sparkline" />
    </svg>
  );
}
