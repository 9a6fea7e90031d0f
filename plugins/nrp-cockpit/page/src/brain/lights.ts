import { heardOf, spikesOf } from "../plots/spikeStore";
import { boxBrightness, boxRates, brightnessOf, ratesNow, rateText } from "./activity";
import type { Graph } from "./graph";
import type { Part } from "./nodes";

/** How the parts of a population shine and fire, in their order. */
interface Activity {
  light: Float64Array;
  rates: Float64Array | null;
}

/** Sets brightness and rates of a drawn graph. The elements are few: small populations and boxes. */
export function shine(svg: SVGSVGElement, { nodes }: Graph, now_s: number): void {
  const lights = new Map<string, number>();
  const known = new Map<string, Activity>();
  const partOf = new Map(nodes.map(({ part }) => [part.id, part]));
  for (const element of svg.querySelectorAll<SVGGElement>("[data-part]")) {
    const part = partOf.get(element.dataset.part ?? "");
    if (!part) continue;
    const { label } = part.population;
    const activity = known.get(label) ?? activityOf(part, now_s);
    known.set(label, activity);
    const at = part.share?.part ?? part.index ?? 0;
    const light = activity.light[at] ?? 0;
    lights.set(part.id, light);
    show(element, light, activity.rates && (activity.rates[at] ?? 0));
  }
  for (const line of svg.querySelectorAll<SVGPathElement>("[data-from]"))
    line.style.setProperty("--light", shortNumber(lights.get(line.dataset.from ?? "") ?? 0));
}

function activityOf({ population: { label, size }, share }: Part, now_s: number): Activity {
  const [spikes, heard] = [spikesOf(label), heardOf(label)];
  if (share === null)
    return { light: brightnessOf(spikes, size, now_s), rates: ratesNow(spikes, heard, size, now_s) };
  const { grouping } = share;
  return { light: boxBrightness(spikes, grouping, now_s), rates: boxRates(spikes, heard, grouping, now_s) };
}

const shortNumber = (value: number) => value.toFixed(2);

function show(element: SVGGElement, light: number, rate_hz: number | null): void {
  element.style.setProperty("--light", shortNumber(light));
  const text = rateText(rate_hz);
  const rate = element.querySelector(".brain-rate");
  if (rate && rate.textContent !== text) rate.textContent = text;
}
