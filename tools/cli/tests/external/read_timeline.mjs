// Reads a timeline with the trace engine of Chromium's developer tools; prints its processes and arrows as JSON.
// Arguments: folder with the package, timeline.
import { readFileSync } from "node:fs";
import { pathToFileURL } from "node:url";

const [folder, timeline] = process.argv.slice(2);
// The engine expects these globals of a browser.
globalThis.window = globalThis;
globalThis.DOMRect = class {};
const entry = `${folder}/node_modules/@paulirish/trace_engine/models/trace/trace.js`;
const { Handlers, Processor, Types } = await import(pathToFileURL(entry));
const settings = Types.Configuration.defaults();
const engine = new Processor.TraceProcessor(Handlers.ModelHandlers, settings);
const { traceEvents } = JSON.parse(readFileSync(timeline, "utf8"));
await engine.parse(traceEvents, {});
const { Flows, Meta } = engine.data;
const name = (event) => Meta.processNames.get(event.pid).args.name;
console.log(
  JSON.stringify({
    processes: [...Meta.processNames.values()].map((event) => event.args.name),
    arrows: Flows.flows.map((flow) => flow.map((event) => [name(event), event.name, event.ts])),
  }),
);
