// The page's elements are known to the scripts by their ids and selectors, whose kinds tsc does not know.

interface EventTarget { [name: string]: any }
interface Event { [name: string]: any }
interface Element { setAttribute(name: string, value: unknown): void }
interface Window { povgen: any }

// Made by povgen from the kinds of sheets: povgen/liveview/laws.js.j2.
declare module "*/laws.js" { export const LAWS: Record<string, any> }
