/* Compiled components in the page: the functions of FMI 3.0 in WebAssembly, by the names of the variables. */

class Library {
  /* The modules of all classes of components by their keys; a description names the variables of one
     (motofmi/workflows/explore.py). One without WebAssembly has a Jacobian instead (GivenPart in linear.js). */
  static async load(descriptions) {
    const libraries = {};
    for (const [key, description] of Object.entries(descriptions)) {
      if (!description.wasm) {
        libraries[key] = description;
        continue;
      }
      const packed = new Blob([Uint8Array.from(atob(description.wasm), (c) => c.charCodeAt(0))]);
      const bytes = await new Response(packed.stream().pipeThrough(new DecompressionStream("deflate-raw"))).arrayBuffer();
      const { instance } = await WebAssembly.instantiate(bytes, {});
      libraries[key] = new Library(instance.exports, description);
    }
    return libraries;
  }

  constructor(exports, description) {
    Object.assign(this, description);
    this.fmi = exports;
    this.token = this.text(description.token);
    this.name = this.text("page");
    this.size = Object.keys(this.references).length;
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
    this.reference = fmi.malloc(4 * library.size + 4);
    this.numbers_at = fmi.malloc(8 * library.size + 8);
    this.flags = fmi.malloc(32);
  }

  free() {
    this.fmi.fmi3FreeInstance(this.instance);
    for (const place of [this.reference, this.numbers_at, this.flags]) this.fmi.free(place);
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
    this.numbers(this.numbers_at, names.length).set(Object.values(values));
    return this.fmi.fmi3SetFloat64(this.instance, this.reference, names.length, this.numbers_at, names.length) <= 1;
  }

  get(names) {
    this.refer(names);
    this.fmi.fmi3GetFloat64(this.instance, this.reference, names.length, this.numbers_at, names.length);
    return Array.from(this.numbers(this.numbers_at, names.length));
  }

  /* A variable by name; undefined where there is none. */
  value(name) { return name in this.library.references ? this.get([name])[0] : undefined; }

  initialise(start = 0) { this.fmi.fmi3EnterInitializationMode(this.instance, 0, 0, start, 0, 0); }

  start() { this.fmi.fmi3ExitInitializationMode(this.instance); }
}

/* d(rows)/d(columns) of an instance, rates and outputs over states and inputs by name. */
class Derivatives {
  constructor(fmu, rows, columns) {
    const { fmi, library } = fmu;
    Object.assign(this, { fmu, count: rows.length, columns: columns.length, rows: library.references_of(rows), seeds: library.references_of(columns) });
    this.seed = fmi.malloc(8);
    this.found = fmi.malloc(8 * rows.length + 8);
    fmu.numbers(this.seed, 1)[0] = 1;
  }

  free() { for (const place of [this.rows, this.seeds, this.seed, this.found]) this.fmu.fmi.free(place); }

  /* Written into `to` (rows x columns) in rows. */
  evaluate(to) {
    const { fmu, fmu: { fmi, instance }, count, columns } = this, first = this.found >> 3;
    for (let j = 0; j < columns; j++) {
      fmi.fmi3GetDirectionalDerivative(instance, this.rows, count, this.seeds + 4 * j, 1, this.seed, 1, this.found, count);
      const memory = fmu.view.buffer === fmi.memory.buffer ? fmu.view : (fmu.numbers(0, 0), fmu.view);
      for (let i = 0; i < count; i++) to[i * columns + j] = memory[first + i];
    }
  }
}
