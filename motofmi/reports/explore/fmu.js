/* Compiled components in the page: the functions of FMI 3.0 in WebAssembly, by the names of the variables. */

class Library {
  /* The modules of all classes of components by their keys; a description names the variables of one
     (motofmi/workflows/explore.py). */
  static async load(descriptions) {
    const all = Object.values(descriptions), names = (kind) => new Set(all.flatMap((d) => d[kind])), libraries = {};
    const inputs = names("inputs"), shared = new Set([...names("outputs")].filter((n) => inputs.has(n)));
    for (const [key, description] of Object.entries(descriptions)) {
      const packed = new Blob([Uint8Array.from(atob(description.wasm), (c) => c.charCodeAt(0))]);
      const bytes = await new Response(packed.stream().pipeThrough(new DecompressionStream("deflate-raw"))).arrayBuffer();
      const { instance } = await WebAssembly.instantiate(bytes, {});
      libraries[key] = new Library(instance.exports, description, shared);
    }
    return libraries;
  }

  /* taken and given: the inputs and outputs that another component could have as well. */
  constructor(exports, description, shared) {
    Object.assign(this, description);
    this.taken = this.inputs.filter((n) => shared.has(n));
    this.given = this.outputs.filter((n) => shared.has(n));
    this.fmi = exports;
    this.token = this.text(description.token);
    this.name = this.text("page");
    this.rows = [...this.states.map((n) => `der(${n})`), ...this.given];
    this.columns = [...this.states, ...this.taken];
    this.rowReferences = this.references_of(this.rows);
    this.columnReferences = this.references_of(this.columns);
  }

  text(value) {
    const bytes = new TextEncoder().encode(value + "\0"), at = this.fmi.malloc(bytes.length);
    new Uint8Array(this.fmi.memory.buffer).set(bytes, at);
    return at;
  }

  references_of(names) {
    const at = this.fmi.malloc(4 * names.length + 4);
    new Uint32Array(this.fmi.memory.buffer, at, names.length).set(names.map((n) => this.references[n]));
    return at;
  }
}

class Fmu {
  /* One instance, in initialisation until `start`; values by name. */
  constructor(library, exchange) {
    this.library = library;
    this.fmi = library.fmi;
    const { name, token, fmi } = library, none = [0, 0, 0, 0];
    this.instance = exchange ? fmi.fmi3InstantiateModelExchange(name, token, 0, ...none)
      : fmi.fmi3InstantiateCoSimulation(name, token, 0, ...none, ...none, 0, 0);
    if (!this.instance) throw new Error(`${library.title}: no instance`);
    this.size = Math.max(library.rows.length, Object.keys(library.references).length) + 1;
    this.reference = fmi.malloc(4 * this.size);
    this.value = fmi.malloc(8 * this.size);
    this.seed = fmi.malloc(8 * this.size);
    this.flags = fmi.malloc(32);
  }

  free() {
    this.fmi.fmi3FreeInstance(this.instance);
    for (const place of [this.reference, this.value, this.seed, this.flags]) this.fmi.free(place);
  }

  /* Numbers in the module's memory, which moves when it grows. */
  numbers(place, count) {
    const memory = this.fmi.memory.buffer;
    if (this.view?.buffer !== memory) this.view = new Float64Array(memory);
    return this.view.subarray(place >> 3, (place >> 3) + count);
  }

  refer(names) {
    const references = new Uint32Array(this.fmi.memory.buffer, this.reference, names.length);
    for (let i = 0; i < names.length; i++) references[i] = this.library.references[names[i]];
  }

  set(values) {
    const names = Object.keys(values);
    this.refer(names);
    this.numbers(this.value, names.length).set(Object.values(values));
    return this.fmi.fmi3SetFloat64(this.instance, this.reference, names.length, this.value, names.length) <= 1;
  }

  get(names) {
    this.refer(names);
    this.fmi.fmi3GetFloat64(this.instance, this.reference, names.length, this.value, names.length);
    return Array.from(this.numbers(this.value, names.length));
  }

  initialise(start = 0) { this.fmi.fmi3EnterInitializationMode(this.instance, 0, 0, start, 0, 0); }

  start() { this.fmi.fmi3ExitInitializationMode(this.instance); }

  /* d(x', y)/d(x, u) in `found`, one row for each rate and shared output, one column for each state and shared input. */
  jacobian(found) {
    const { library, fmi } = this, rows = library.rows.length, columns = library.columns.length;
    this.numbers(this.seed, 1)[0] = 1;
    for (let j = 0; j < columns; j++) {
      fmi.fmi3GetDirectionalDerivative(this.instance, library.rowReferences, rows, library.columnReferences + 4 * j, 1, this.seed, 1, this.value, rows);
      const memory = this.view, first = this.value >> 3;
      for (let i = 0; i < rows; i++) found[i * columns + j] = memory[first + i];
    }
    return found;
  }
}
