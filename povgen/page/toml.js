// A reader of TOML, of what a room's file needs: tables and lists of tables; text in a line, numbers, true and false, lists, and
// tables in a line.

// What is between the parts of a line, between those of a list, and at a line's end.
const SPACE = /[ \t]*/y, BREAKS = /(?:[ \t\r\n]|#[^\n]*)*/y, END = /[ \t]*(?:#[^\n]*)?(?:\r?\n|$)/y;
const TEXT = /"((?:[^"\\\n]|\\["\\bfnrt]|\\u[\da-fA-F]{4})*)"|'([^'\n]*)'/y, BARE = /[\w-]+/y;
const NUMBER = /[+-]?\d+(?:_\d+)*(?:\.\d+(?:_\d+)*)?(?:[eE][+-]?\d+)?/y, TRUTH = /true|false/y;

// The table that a text states. Throws an error whose message is the number of the line that cannot be read.
export const parsed = (text) => new Reader(text).file();

class Reader {
  constructor(text) {
    this.text = text;
    this.at = 0;
  }

  take(pattern) {
    pattern.lastIndex = this.at;
    const found = pattern.exec(this.text);
    if (found) this.at = pattern.lastIndex;
    return found;
  }

  // Whether these letters are next: then they are read.
  skip(letters, space = SPACE) {
    this.take(space);
    const found = this.text.startsWith(letters, this.at);
    if (found) this.at += letters.length;
    return found;
  }

  need(found) {
    if (!found) throw new Error(String(this.text.slice(0, this.at).split("\n").length));
    return found;
  }

  string() {
    const found = this.take(TEXT);
    return found && (found[2] ?? JSON.parse(`"${found[1].replaceAll("\t", "\\t")}"`));
  }

  // The names of a key, as of `eye.z`.
  names() {
    const found = [];
    do {
      this.take(SPACE);
      found.push(this.string() ?? this.need(this.take(BARE))[0]);
    } while (this.skip("."));
    return found;
  }

  value() {
    const text = this.string();
    if (text !== null) return text;
    if (this.skip("[")) return this.list();
    if (this.skip("{")) return this.table();
    const truth = this.take(TRUTH);
    return truth ? truth[0] === "true" : Number(this.need(this.take(NUMBER))[0].replaceAll("_", ""));
  }

  list() {
    const found = [];
    while (!this.skip("]", BREAKS)) {
      found.push(this.value());
      if (this.skip(",", BREAKS)) continue;
      this.need(this.skip("]", BREAKS));
      break;
    }
    return found;
  }

  table() {
    const made = {};
    if (this.skip("}")) return made;
    do this.pair(made);
    while (this.skip(","));
    this.need(this.skip("}"));
    return made;
  }

  pair(outer) {
    const names = this.names();
    this.need(this.skip("="));
    this.take(SPACE);
    this.put(outer, names, this.value());
  }

  // Put a value into a table, or into one within it. Of a list of tables, that is the last.
  put(outer, names, value) {
    const last = names.pop();
    for (const name of names) {
      if (!Object.hasOwn(outer, name)) outer[name] = {};
      outer = Array.isArray(outer[name]) ? outer[name].at(-1) : outer[name];
      this.need(typeof outer === "object");
    }
    this.need(!Object.hasOwn(outer, last));
    outer[last] = value;
  }

  // The table that a line like [eye] or [[window]] begins.
  header(root) {
    const several = this.skip("["), names = this.names(), made = {}, [name] = names;
    this.need(this.skip(several ? "]]" : "]"));
    if (several && names.length === 1 && Array.isArray(root[name])) root[name].push(made);
    else this.put(root, names, several ? [made] : made);
    return made;
  }

  file() {
    const root = {};
    let present = root;
    for (this.take(BREAKS); this.at < this.text.length; this.take(BREAKS)) {
      if (this.skip("[")) present = this.header(root);
      else this.pair(present);
      this.need(this.take(END));
    }
    return root;
  }
}
