import { ExpressionField } from "./ExpressionField";
import { PartField } from "./PartField";
import { PartList } from "./PartList";
import { useDesign } from "./store";
import type { DesignState, Feature, Held, NodeData } from "./types";
import { ValueField } from "./ValueField";

interface FormProps {
  path: string;
  part: NodeData;
}

/** Lists that the drawing shows already. */
const DRAWN = new Set(["transfer_function"]);
/** What can be changed in every brain, also in one that a person wrote. */
const IN_EVERY_BRAIN = "intervention";

/** The form of a part, made from the server's description of its class; what is seldom given is folded away. */
export function PartForm({ path, part }: FormProps) {
  const all = useDesign((design) => design.metamodel?.classes[part.type]?.features) ?? [];
  const kind = useDesign((design) => design.state?.kind);
  const byHand = useDesign((design) => path === "" && design.state?.is_drawn === false);
  const shown = all.filter(({ field }) => !DRAWN.has(field) && (!byHand || field === IN_EVERY_BRAIN));
  const first = shown.filter((feature) => !isSeldom(feature, part, kind));
  const seldom = shown.filter((feature) => isSeldom(feature, part, kind));
  const field = (feature: Feature) => (
    <FormField key={feature.field} path={path} part={part} feature={feature} />
  );
  return (
    <div className="form">
      {first.toSorted((one, other) => weightOf(one) - weightOf(other)).map(field)}
      {seldom.length > 0 && (
        <details>
          <summary>More</summary>
          <div className="form">{seldom.map(field)}</div>
        </details>
      )}
    </div>
  );
}

const isExpression = ({ of, many }: Feature) => of === "FlowExpression" && !many;
const weightOf = (feature: Feature) => (feature.is_node ? (isExpression(feature) ? 2 : 1) : 0);

/** Whether a part need not be there and is not: settings of synapses, files of the platform. */
function isSeldom(feature: Feature, part: NodeData, kind: DesignState["kind"] | undefined): boolean {
  const held = part.fields[feature.field] ?? null;
  if (kind === "brain") return feature.field.startsWith("initial_") && held === null;
  if (isExpression(feature) || feature.least > 0 || feature.field === "name") return false;
  if (Array.isArray(held)) return held.length === 0;
  return feature.is_node ? held === null : held === null || held === feature.default;
}

const isPart = (held: Held | undefined): held is NodeData =>
  typeof held === "object" && held !== null && !Array.isArray(held);

function FormField({ path, part, feature }: FormProps & { feature: Feature }) {
  const held = part.fields[feature.field] ?? null;
  const device = useDesign((design) => design.metamodel?.devices[String(part.fields.type)]);
  if (!feature.is_node) return <ValueField path={path} part={part} feature={feature} />;
  if (feature.many && Array.isArray(held))
    return <PartList path={path} feature={feature} parts={held.filter(isPart)} />;
  const inner = isPart(held) ? held : null;
  const below = path ? `${path}/${feature.field}` : feature.field;
  const blocks = (
    <PartField path={path} feature={feature} part={inner}>
      {inner && <PartForm path={below} part={inner} />}
    </PartField>
  );
  if (feature.of !== "FlowExpression") return blocks;
  const isValue = feature.field === "body" && device !== undefined;
  return (
    <ExpressionField
      path={path}
      feature={feature}
      part={inner}
      title={isValue ? device.property : feature.name}
      unit={isValue ? device.unit : ""}
    >
      {blocks}
    </ExpressionField>
  );
}
