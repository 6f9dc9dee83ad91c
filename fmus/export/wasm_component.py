"""A WebAssembly component around a module: the interface of fmi-ls-wasm on the functions of `fmi3_component.c`.

The encoding is that of the WebAssembly Component Model (component-model/design/mvp/Binary.md); a component is a list of
sections, each of which defines items that later sections refer to by their number. The module comes first, so that a
browser, which opens modules alone, finds it at the start of the file (`core_module`).

    component = module, and for each interface: its resource, its functions lifted from the module,
                and an inner component that gives the types of the interface their names
"""

from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from xml.etree import ElementTree as Xml

from fmus.export.model_description2 import to_bytes
from fmus.export.wasm_interface import (
    COMMON,
    EVERY_KIND,
    KINDS,
    MANIFEST,
    MANIFEST_ATTRIBUTES,
    PLATFORM,
    TYPES,
    VERSION,
    Function,
    Kind,
    fields,
    functions,
    split,
)

HEADER = b"\0asm\x0d\0\x01\0"
MODULE_HEADER = b"\0asm\x01\0\0\0"
PRIMITIVE = {"bool": 0x7F, "s8": 0x7E, "u8": 0x7D, "s16": 0x7C, "u16": 0x7B, "s32": 0x7A, "u32": 0x79, "s64": 0x78,
             "u64": 0x77, "f32": 0x76, "f64": 0x75, "string": 0x73}  # fmt: skip
# Sections and sorts of items, as the encoding numbers them.
CORE_MODULE, CORE_INSTANCE, COMPONENT, INSTANCE, ALIAS, TYPE, CANON, IMPORT, EXPORT = 1, 2, 4, 5, 6, 7, 8, 10, 11
CORE_FUNCTION_SORT, CORE_MEMORY_SORT, CORE_INSTANCE_SORT = b"\x00", b"\x02", b"\x12"
FUNCTION_SORT, TYPE_SORT, INSTANCE_SORT = b"\x01", b"\x03", b"\x05"


def additions(library: str, module: bytes) -> dict[str, bytes]:
    """What fmi-ls-wasm asks for in an archive besides the module, by the path in the archive."""
    manifest = Xml.Element("fmiLayeredStandardManifest", MANIFEST_ATTRIBUTES)
    return {f"binaries/{PLATFORM}/{library}": component(module), MANIFEST: to_bytes(manifest)}


def component(module: bytes) -> bytes:
    """The component of a module that exports the functions of `runtime/fmi3_component.c`."""
    outer = Sections()
    outer.add(CORE_MODULE, module, "module")
    fmu = outer.add(CORE_INSTANCE, b"\0" + number(0) + vector([]), "core instance")
    memory = outer.core_export(fmu, "memory", CORE_MEMORY_SORT)
    realloc, after = (outer.core_export(fmu, f"component_{name}") for name in ("realloc", "after"))
    options = vector([b"\0", b"\x03" + number(memory), b"\x04" + number(realloc), b"\x05" + number(after)])
    (version,) = functions(VERSION)
    lifted = outer.lift(outer.core_export(fmu, version.symbol), version, {}, options)
    made = outer.add(INSTANCE, b"\x01" + vector([name(version.name) + FUNCTION_SORT + number(lifted)]), "instance")
    outer.export(COMMON, INSTANCE_SORT, made)
    for kind in KINDS:
        _add_interface(outer, kind, fmu, memory, options)
    return HEADER + b"".join(outer.content)


def core_module(made: bytes) -> bytes:
    """The module of a component that `component` made."""
    size, start = read_number(made, len(HEADER) + 1)
    return made[start : start + size]


def _add_interface(outer: "Sections", kind: Kind, fmu: int, memory: int, options: bytes) -> None:
    """An interface of the component: its resource, its functions, and the names of its types."""
    release = outer.core_export(fmu, "component_free")
    resource = outer.add(TYPE, b"\x3f\x7f\x01" + number(release), "type")
    own = outer.add(CANON, b"\x02" + number(resource), "core function")
    types = {kind.resource: resource}
    outer.define_named(types, kind)
    (create,) = functions(kind.create)
    methods = [Function(f.name, (("self", f"borrow<{kind.resource}>"), *f.parameters), f.result)
               for f in every_function(kind)]  # fmt: skip
    cores = [_created(outer, create, fmu, memory, own), *(outer.core_export(fmu, m.symbol) for m in methods)]
    named = [(f"[static]{kind.resource}.{create.name}", create)]
    named += [(f"[method]{kind.resource}.{m.name}", m) for m in methods]
    lifted = [outer.lift(core, f, types, options) for core, (_, f) in zip(cores, named, strict=True)]
    inner = outer.add(COMPONENT, _component_of_names(kind, [*named]), "component")
    arguments = [_argument(f"type-{n}", TYPE_SORT, types[n]) for n in types]
    arguments += [_argument(f"function-{f.name}", FUNCTION_SORT, i) for i, (_, f) in zip(lifted, named, strict=True)]
    made = outer.add(INSTANCE, b"\0" + number(inner) + vector(arguments), "instance")
    outer.export(kind.interface, INSTANCE_SORT, made)


def every_function(kind: Kind) -> list[Function]:
    """The methods of an instance of that kind."""
    return [*functions(EVERY_KIND), *functions(kind.functions)]


def _argument(parameter: str, sort: bytes, index: int) -> bytes:
    return text(parameter) + sort + number(index)


def _component_of_names(kind: Kind, named: Sequence[tuple[str, Function]]) -> bytes:
    """A component that imports types and functions and exports them as one instance.

    Only a component can give a type the name by which the functions that it exports refer to it.
    """
    inner = Sections()
    imported = {kind.resource: inner.import_(f"type-{kind.resource}", b"\x03\x01", "type")}
    inner.define_named(imported, kind, lambda n, i: inner.import_(f"type-{n}", b"\x03\x00" + number(i), "type"))
    given = [inner.import_(f"function-{f.name}", b"\x01" + number(inner.function_type(f, imported)), "function")
             for _, f in named]  # fmt: skip
    exported = {kind.resource: inner.export(kind.resource, TYPE_SORT, imported[kind.resource], "type")}
    inner.define_named(exported, kind, lambda n, i: inner.export(n, TYPE_SORT, i, "type"))
    for index, (label, function) in zip(given, named, strict=True):
        described = b"\x01\x01" + number(inner.function_type(function, exported))
        inner.export(label, FUNCTION_SORT, index, "function", described)
    return HEADER + b"".join(inner.content)


def _created(outer: "Sections", create: Function, fmu: int, memory: int, own: int) -> int:
    """The function that creates an instance, with the instance replaced by a handle of its resource.

    The handle comes from a function of the component, which the module, having no imports, cannot call: a small module
    calls both.
    """
    count = sum(2 if kind == "string" or kind.startswith("list<") else 1 for _, kind in create.parameters)
    outer.add(CORE_MODULE, _creating_module(create.symbol, count), "module")
    exports = [text("memory") + CORE_MEMORY_SORT + number(memory), text("own") + CORE_FUNCTION_SORT + number(own)]
    given = outer.add(CORE_INSTANCE, b"\x01" + vector(exports), "core instance")
    arguments = [text("fmu") + CORE_INSTANCE_SORT + number(fmu), text("host") + CORE_INSTANCE_SORT + number(given)]
    module = number(outer.count["module"] - 1)
    made = outer.add(CORE_INSTANCE, b"\0" + module + vector(arguments), "core instance")
    return outer.core_export(made, "create")


def _creating_module(symbol: str, count: int) -> bytes:
    """result = create(...); if (result->is_there) result->instance = own(result->instance); return result"""
    i32 = b"\x7f"
    types = [b"\x60" + vector([i32] * count) + vector([i32]), b"\x60" + vector([i32]) + vector([i32])]
    imports = [text("fmu") + text(symbol) + b"\0\0", text("host") + text("own") + b"\0\x01",
               text("host") + text("memory") + b"\x02\0\0"]  # fmt: skip
    result = b"\x20" + number(count)  # local.get
    body = b"".join(b"\x20" + number(k) for k in range(count)) + b"\x10\0" + b"\x21" + number(count)
    body += result + b"\x2d\0\0" + b"\x04\x40"  # i32.load8_u, if
    body += result + result + b"\x28\x02\x04" + b"\x10\x01" + b"\x36\x02\x04" + b"\x0b" + result + b"\x0b"
    code = vector([b"\x01" + i32]) + body
    sections = [(1, vector(types)), (2, vector(imports)), (3, vector([b"\0"])),
                (7, vector([text("create") + b"\0\x02"])), (10, vector([number(len(code)) + code]))]  # fmt: skip
    return MODULE_HEADER + b"".join(section(*s) for s in sections)


class Sections:
    """The sections of a component, and how many items of each sort they have defined."""

    def __init__(self) -> None:
        self.content: list[bytes] = []
        self.count: Counter[str] = Counter()
        self.known: dict[bytes, int] = {}

    def add(self, place: int, item: bytes, sort: str) -> int:
        """One section with one item; the number of the item among those of its sort."""
        whole = place in (CORE_MODULE, COMPONENT)
        self.content.append(section(place, item if whole else number(1) + item))
        self.count[sort] += 1
        return self.count[sort] - 1

    def core_export(self, instance: int, label: str, sort: bytes = CORE_FUNCTION_SORT) -> int:
        """An export of an instance of a module."""
        sorts = {CORE_FUNCTION_SORT: "core function", CORE_MEMORY_SORT: "memory"}
        return self.add(ALIAS, b"\0" + sort + b"\x01" + number(instance) + text(label), sorts[sort])

    def import_(self, label: str, description: bytes, sort: str) -> int:
        return self.add(IMPORT, name(label) + description, sort)

    def export(self, label: str, sort: bytes, index: int, kind: str = "instance", described: bytes = b"\0") -> int:
        return self.add(EXPORT, name(label) + sort + number(index) + described, kind)

    def lift(self, core: int, function: Function, types: dict[str, int], options: bytes) -> int:
        """A function of a module as a function of the component."""
        kind = number(self.function_type(function, types))
        return self.add(CANON, b"\0\0" + number(core) + options + kind, "function")

    def define_named(
        self, types: dict[str, int], kind: Kind, named: Callable[[str, int], int] = lambda label, index: index
    ) -> None:
        """The named types of an interface are added to `types`, with the number that `named` gives them."""
        for label, definition in (*TYPES.items(), kind.own_type):
            types[label] = named(label, self.type(self._definition(definition, types)))

    def function_type(self, function: Function, types: dict[str, int]) -> int:
        parameters = [text(label) + self.value(kind, types) for label, kind in function.parameters]
        return self.type(b"\x40" + vector(parameters) + b"\0" + self.value(function.result, types))

    def type(self, definition: bytes) -> int:
        """The number of a type; equal definitions are one."""
        if definition not in self.known:
            self.known[definition] = self.add(TYPE, definition, "type")
        return self.known[definition]

    def _definition(self, definition: str, types: dict[str, int]) -> bytes:
        word, _, rest = definition.partition(" ")
        if word == "enum":
            return b"\x6d" + vector(text(case) for case in split(rest))
        if word == "record":
            return b"\x72" + vector(text(label) + self.value(kind, types) for label, kind in fields(rest))
        return bytes([PRIMITIVE[definition]]) if definition in PRIMITIVE else self._compound(definition, types)

    def _compound(self, kind: str, types: dict[str, int]) -> bytes:
        word, _, rest = kind.partition("<")
        parts = split(rest.removesuffix(">"))
        if word == "borrow":
            return b"\x68" + number(types[parts[0]])
        if word == "option" and parts[0] in types and parts[0].endswith("-instance"):
            return b"\x6b" + signed(self.type(b"\x69" + number(types[parts[0]])))
        values = [self.value(part, types) for part in parts]
        return {
            "list": lambda: b"\x70" + values[0],
            "option": lambda: b"\x6b" + values[0],
            "tuple": lambda: b"\x6f" + vector(values),
            "result": lambda: b"\x6a" + b"".join(b"\x01" + v for v in values),
        }[word]()

    def value(self, kind: str, types: dict[str, int]) -> bytes:
        """A type where a value of it is expected."""
        if kind in PRIMITIVE:
            return bytes([PRIMITIVE[kind]])
        return signed(types[kind] if kind in types else self.type(self._compound(kind, types)))


def number(value: int) -> bytes:
    """An unsigned number in LEB128."""
    made = bytearray()
    while True:
        value, digit = value >> 7, value & 0x7F
        made.append(digit | (0x80 if value else 0))
        if not value:
            return bytes(made)


def signed(value: int) -> bytes:
    """A number of a type in signed LEB128: its sign bit must be clear."""
    made = number(value)
    return made if not made[-1] & 0x40 else made[:-1] + bytes([made[-1] | 0x80, 0])


def read_number(data: bytes, place: int) -> tuple[int, int]:
    """The unsigned number in LEB128 at a place, and the place behind it."""
    value = shift = 0
    while True:
        value |= (data[place] & 0x7F) << shift
        shift, place = shift + 7, place + 1
        if not data[place - 1] & 0x80:
            return value, place


def text(value: str) -> bytes:
    return number(len(value.encode())) + value.encode()


def name(value: str) -> bytes:
    """The name of an import or export of a component."""
    return b"\0" + text(value)


def vector(items: Iterable[bytes]) -> bytes:
    listed = list(items)
    return number(len(listed)) + b"".join(listed)


def section(place: int, content: bytes) -> bytes:
    return bytes([place]) + number(len(content)) + content
