// Foxglove's own client: hears topics of a cockpit, calls a service, publishes, and prints what it got as JSON.
import { createRequire } from "node:module";

const require = createRequire(new URL("../page/package.json", import.meta.url));
const { FoxgloveClient } = require("@foxglove/ws-protocol");

const [address, protocol, ...wanted] = process.argv.slice(2);
const client = new FoxgloveClient({ ws: new WebSocket(address, [protocol]) });
const got = { topics: {}, answers: [], statuses: [] };
const names = new Map();
const services = new Map();

client.on("error", (error) => {
  console.error(String(error));
  process.exit(1);
});
client.on("serverInfo", (info) => {
  got.info = info;
});
client.on("status", (status) => got.statuses.push(status.message));
client.on("advertise", (channels) => {
  for (const channel of channels)
    if (wanted.includes(channel.topic)) names.set(client.subscribe(channel.id), channel);
});
client.on("message", ({ subscriptionId, timestamp, data }) => {
  const { topic, encoding, schemaName, schema } = names.get(subscriptionId);
  const bytes = Buffer.from(data.buffer, data.byteOffset, data.byteLength).toString("base64");
  got.topics[topic] = { encoding, schemaName, schema, bytes, t_ns: String(timestamp) };
  look();
});
client.on("serviceCallResponse", ({ data }) => {
  got.answers.push(Buffer.from(data.buffer, data.byteOffset, data.byteLength).toString());
  look();
});
client.on("serviceCallFailure", (answer) => {
  got.answers.push(answer.message);
  look();
});
client.on("advertiseServices", (offered) => {
  for (const { id, name } of offered) services.set(name, id);
  const call = (name, request) =>
    client.sendServiceCallRequest({
      serviceId: services.get(name),
      callId: got.answers.length + 1,
      encoding: "json",
      data: new DataView(new TextEncoder().encode(JSON.stringify(request)).buffer),
    });
  call("/cockpit/step", { n: 10 });
  const channel = client.advertise({ topic: "/husky/cmd_vel", encoding: "json", schemaName: "geometry_msgs/Twist" });
  client.sendMessage(channel, new TextEncoder().encode(JSON.stringify({ linear: { x: 0.5 } })));
});

function look() {
  if (got.answers.length > 0 && wanted.every((name) => name in got.topics)) finish();
}

function finish() {
  setTimeout(() => {
    console.log(JSON.stringify(got));
    process.exit(0);
  }, 300);
}
setTimeout(() => {
  console.log(JSON.stringify(got));
  process.exit(2);
}, 60_000);
