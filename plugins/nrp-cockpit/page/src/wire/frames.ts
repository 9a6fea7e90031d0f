/**
 * The messages of the Foxglove WebSocket protocol that this page uses.
 * https://github.com/foxglove/ws-protocol/blob/main/docs/spec.md
 */

export const SUBPROTOCOLS = ["foxglove.sdk.v1", "foxglove.websocket.v1"];

/** The first byte of a binary frame. */
const FromServer = { Message: 1, Time: 2, ServiceResponse: 3 } as const;
const FromClient = { Message: 1, ServiceRequest: 2 } as const;

export interface Channel {
  id: number;
  topic: string;
  encoding: string;
  schemaName: string;
  schema: string;
  schemaEncoding?: string;
}

export interface Service {
  id: number;
  name: string;
}

export type ServerText =
  | { op: "serverInfo"; name: string; capabilities: string[]; sessionId?: string }
  | { op: "status"; level: number; message: string }
  | { op: "advertise"; channels: Channel[] }
  | { op: "unadvertise"; channelIds: number[] }
  | { op: "advertiseServices"; services: Service[] }
  | { op: "unadvertiseServices"; serviceIds: number[] }
  | { op: "serviceCallFailure"; serviceId: number; callId: number; message: string };

/** A call of a service with the arguments by their names. */
export interface ServiceRequest {
  serviceId: number;
  callId: number;
  arguments: Record<string, unknown>;
}

export type ServerBinary =
  | { op: "message"; subscriptionId: number; t_s: number; data: DataView }
  | { op: "time"; t_s: number }
  | { op: "response"; callId: number; encoding: string; data: DataView };

const text = { encode: new TextEncoder(), decode: new TextDecoder() };

const seconds = (view: DataView, at: number) =>
  (view.getUint32(at, true) + view.getUint32(at + 4, true) * 2 ** 32) * 1e-9;

const rest = (view: DataView, at: number) =>
  new DataView(view.buffer, view.byteOffset + at, view.byteLength - at);

export const textOf = (view: DataView): string => text.decode.decode(view);

/** Reads a binary frame; null for an operation that this page does not use. */
export function readBinary(buffer: ArrayBuffer): ServerBinary | null {
  const view = new DataView(buffer);
  switch (view.getUint8(0)) {
    case FromServer.Message:
      return {
        op: "message",
        subscriptionId: view.getUint32(1, true),
        t_s: seconds(view, 5),
        data: rest(view, 13),
      };
    case FromServer.Time:
      return { op: "time", t_s: seconds(view, 1) };
    case FromServer.ServiceResponse: {
      const length = view.getUint32(9, true);
      const encoding = text.decode.decode(new Uint8Array(buffer, 13, length));
      return { op: "response", callId: view.getUint32(5, true), encoding, data: rest(view, 13 + length) };
    }
    default:
      return null;
  }
}

/** A call of a service with a JSON request. */
export function writeServiceRequest(serviceId: number, callId: number, request: object): Uint8Array {
  const encoding = text.encode.encode("json");
  const payload = text.encode.encode(JSON.stringify(request));
  const bytes = new Uint8Array(13 + encoding.length + payload.length);
  const view = new DataView(bytes.buffer);
  view.setUint8(0, FromClient.ServiceRequest);
  view.setUint32(1, serviceId, true);
  view.setUint32(5, callId, true);
  view.setUint32(9, encoding.length, true);
  bytes.set(encoding, 13);
  bytes.set(payload, 13 + encoding.length);
  return bytes;
}

/** A message on a channel that the client advertised, in JSON. */
export function writeClientMessage(channelId: number, value: object): Uint8Array {
  const payload = text.encode.encode(JSON.stringify(value));
  const bytes = new Uint8Array(5 + payload.length);
  const view = new DataView(bytes.buffer);
  view.setUint8(0, FromClient.Message);
  view.setUint32(1, channelId, true);
  bytes.set(payload, 5);
  return bytes;
}

/** Reads what `writeServiceRequest` wrote; null for another operation. */
export function readServiceRequest(bytes: Uint8Array): ServiceRequest | null {
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  if (view.getUint8(0) !== FromClient.ServiceRequest) return null;
  const payload = textOf(rest(view, 13 + view.getUint32(9, true)));
  return {
    serviceId: view.getUint32(1, true),
    callId: view.getUint32(5, true),
    arguments: JSON.parse(payload || "{}"),
  };
}

/** A message on a channel, as a server sends it. */
export function writeMessage(subscriptionId: number, t_ns: number, payload: Uint8Array): ArrayBuffer {
  const bytes = new Uint8Array(13 + payload.length);
  const view = new DataView(bytes.buffer);
  view.setUint8(0, FromServer.Message);
  view.setUint32(1, subscriptionId, true);
  view.setUint32(5, t_ns % 2 ** 32, true);
  view.setUint32(9, Math.floor(t_ns / 2 ** 32), true);
  bytes.set(payload, 13);
  return bytes.buffer;
}

/** The answer to a call, as a server sends it. */
export function writeResponse(request: ServiceRequest, value: object): ArrayBuffer {
  const bytes = writeServiceRequest(request.serviceId, request.callId, value);
  bytes[0] = FromServer.ServiceResponse; // which has the same form
  return bytes.buffer as ArrayBuffer;
}
