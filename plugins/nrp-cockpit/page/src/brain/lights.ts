import { heardOf, spikesOf } from "../plots/spikeStore";
import type { Population } from "../state/types";
import { brightnessOf, meanOf, ratesNow } from "./activity";
import type { Graph } from "./graph";
import type { Part } from "./nodes";

/** Sets brightness and rates of a drawn graph. The elements are few: small populations and boxes. */
export function shine(svg: SVGSVGElement, { nodes }: Graph, now_s: number): void {
  const lights = new Map<string, number>();
  const activity = new Map<Population, { light: Float64Array; rates: Float64Array | null }>();
  const activityOf = (population: Population) => {
    const spikes = spikesOf(population.label);
    const known = activity.get(population) ?? {
      light: brightnessOf(spikes, population.size, now_s),
      rates: ratesNow(spikes, heardOf(population.label), population.size, now_s),
    };
    activity.set(population, known);
    return known;
  };
  const partOf = new Map(nodes.map(({ part }) => [part.id, part]));
  for (const element of svg.querySelectorAll<SVGGElement>("[data-part]")) {
    const part = partOf.get(element.dataset.part ?? "");
    if (!part) continue;
    const { light, rates } = activityOf(part.population);
    lights.set(part.id, ofPart(part, light));
    show(element, ofPart(part, light), rates && ofPart(part, rates));
  }
  for (const line of svg.querySelectorAll<SVGPathElement>("[data-from]"))
    line.style.setProperty("--light", shortNumber(lights.get(line.dataset.from ?? "") ?? 0));
}

const ofPart = ({ index }: Part, values: Float64Array): number =>
  index === null ? meanOf(values) : (values[index] ?? 0);

const shortNumber = (value: number) => value.toFixed(2);

const rateText = (rate_hz: number) =>
  rate_hz < 10 ? rate_hz.toFixed(rate_hz === 0 ? 0 : 1) : String(Math.round(rate_hz));

function show(element: SVGGElement, light: number, rate_hz: number | null): void {
  element.style.setProperty("--light", shortNumber(light));
  const text = `${rate_hz === null ? "–" : rateText(rate_hz)} Hz`;
  const rate = element.querySelector(".brain-rate");
  if (rate && rate.textContent !== text) rate.textContent = text;
}
