"""Executes function blocks in structured text: blark parses them, this program translates its tree to Python and runs it.

Strict where a PLC is: a value outside the range of its type, an index outside its array and a division by zero end the program.
Arithmetic of REAL is rounded to 32 bits after each operation. Strict also where tools differ: INT and DINT do not mix, an argument is no
element of an array, a loop FOR begins below its end, and no REAL becomes a whole number.

Each line on standard input calls a block: NAME INSTANCE VARIABLE=VALUE ...; octets are hexadecimal. The answer has the outputs.
"""

import math
import struct
import sys

import blark.parse
import blark.transform as tree

RANGES = {"INT": (-32768, 32767), "DINT": (-(2**31), 2**31 - 1), "BYTE": (0, 255)}


def real(number):
    try:
        return struct.unpack("f", struct.pack("f", number))[0]
    except OverflowError:
        return math.copysign(math.inf, number)


def ranged(kind, value):
    low, high = RANGES[kind]
    if not low <= value <= high:
        raise ValueError(f"{value} is no {kind}")
    return value


def item(array, low, index):
    if not 0 <= index - low < len(array):
        raise IndexError(f"index {index} of an array from {low} with {len(array)} elements")
    return index - low


def quotient(dividend, divisor):
    return int(abs(dividend) // abs(divisor)) * (1 if (dividend < 0) == (divisor < 0) else -1)


def remainder(dividend, divisor):
    return dividend - quotient(dividend, divisor) * divisor


def wider(one, other):
    if one == other:
        return one
    raise TypeError(f"{one} with {other}: convert one of them")


class Block:
    """One function block: its variables with their types, and its statements as a Python function."""

    def __init__(self, node):
        self.types, self.arrays, self.start, self.outputs, self.inputs = {}, {}, {}, [], []
        for section in node.declarations:
            for declaration in section.items:
                self.declare(section, declaration)
        self.lines = []
        self.depth = 1
        self.statements(node.body.statements)
        text = "def run(v):\n" + "\n".join(self.lines or ["    pass"])
        space = dict(real=real, ranged=ranged, item=item, quotient=quotient, remainder=remainder, exp=math.exp)
        exec(compile(text, str(node.name), "exec"), space)
        self.run = space["run"]

    def declare(self, section, declaration):
        if isinstance(declaration, tree.ArrayVariableInitDeclaration):
            spec = declaration.init.spec
            (subrange,) = spec.subranges
            low, high = int(str(subrange.start)), int(str(subrange.stop))
            kind = str(spec.type)
            value = [self.zero(kind)] * (high - low + 1)
        else:
            low, kind = None, str(declaration.init.spec.type)
            initial = declaration.init.value
            value = self.zero(kind) if initial is None else self.literal(initial, kind)
        for variable in declaration.variables:
            name = str(variable.variable.name)
            if name in self.types:
                raise KeyError(f"{name} is declared twice")
            self.types[name], self.start[name] = kind, value
            if low is not None:
                self.arrays[name] = low
            if isinstance(section, tree.OutputDeclarations):
                self.outputs.append(name)
            if isinstance(section, tree.InputDeclarations):
                self.inputs.append(name)

    @staticmethod
    def zero(kind):
        return {"REAL": 0.0, "BOOL": False}.get(kind, 0)

    @staticmethod
    def literal(node, kind):
        return real(float(str(node))) if kind == "REAL" else ranged(kind, int(str(node)))

    def emit(self, line):
        self.lines.append("    " * self.depth + line)

    def nested(self, head, statements):
        self.emit(head)
        self.depth += 1
        self.statements(statements)
        self.emit("pass")
        self.depth -= 1

    def statements(self, statements):
        for statement in statements.statements if isinstance(statements, tree.StatementList) else statements or []:
            self.statement(statement)

    def condition(self, node):
        code, kind = self.expression(node)
        if kind != "BOOL":
            raise TypeError(f"{node} is no BOOL")
        return code

    def statement(self, node):
        match node:
            case tree.AssignmentStatement(variables=[target], expression=expression):
                code, kind = self.expression(expression)
                place, wanted = self.place(target)
                self.emit(f"{place} = {self.assigned(code, kind, wanted, node)}")
            case tree.IfStatement():
                self.nested(f"if {self.condition(node.if_expression)}:", node.statements)
                for branch in node.else_ifs:
                    self.nested(f"elif {self.condition(branch.if_expression)}:", branch.statements)
                if node.else_clause:
                    self.nested("else:", node.else_clause.statements)
            case tree.CaseStatement():
                code, _ = self.expression(node.expression)
                self.emit(f"chosen = {code}")
                for number, case in enumerate(node.cases):
                    matches = ", ".join(str(int(str(one))) for one in case.matches)
                    self.nested(f"{'el' if number else ''}if chosen in ({matches},):", case.statements)
                if node.else_clause:
                    self.nested("else:", node.else_clause.statements)
            case tree.ForStatement(step=None):
                place, kind = self.place(node.control)
                if int(str(node.from_)) >= int(str(node.to)):
                    raise ValueError(f"{node} runs once or never")
                low, high = self.expression(node.from_)[0], self.expression(node.to)[0]
                self.emit(f"{place} = {low}")
                self.emit(f"last = {high}")
                self.emit(f"while {place} <= last:")
                self.depth += 1
                self.emit("kept = last")
                self.statements(node.statements)
                self.emit("last = kept")
                self.emit(f"{place} = ranged({kind!r}, {place} + 1)")
                self.depth -= 1
            case tree.WhileStatement():
                self.nested(f"while {self.condition(node.expression)}:", node.statements)
            case _:
                raise TypeError(f"{type(node).__name__}: {node}")

    @staticmethod
    def assigned(code, kind, wanted, node):
        if kind == wanted:
            return f"ranged({kind!r}, {code})" if kind in RANGES else code
        if (kind, wanted) in {("literal", "DINT"), ("literal", "INT")}:
            return f"ranged({wanted!r}, {code})"
        raise TypeError(f"{kind} to {wanted}: {node}")

    def place(self, node):
        match node:
            case tree.SimpleVariable(name=name):
                if str(name) in self.arrays:
                    raise TypeError(f"{name} is an array")
                return f"v[{str(name)!r}]", self.types[str(name)]
            case tree.MultiElementVariable(elements=[tree.SubscriptList(subscripts=[index])]):
                name = str(node.name.name)
                code, kind = self.expression(index)
                if kind not in ("INT", "literal"):
                    raise TypeError(f"the index {index} is a {kind}")
                array = f"v[{name!r}]"
                return f"{array}[item({array}, {self.arrays[name]}, {code})]", self.types[name]
        raise TypeError(f"{type(node).__name__}: {node}")

    def expression(self, node):
        match node:
            case tree.Integer():
                return f"({int(str(node))})", "literal"
            case tree.Real():
                return f"({real(float(str(node)))!r})", "REAL"
            case tree.Boolean():
                return str(str(node).upper() == "TRUE"), "BOOL"
            case tree.ParenthesizedExpression():
                return self.expression(node.expr)
            case tree.UnaryOperation(op=op):
                code, kind = self.expression(node.expr)
                if str(op).upper() == "NOT" and kind == "BOOL":
                    return f"(not {code})", kind
                if str(op) == "-" and kind in ("literal", "REAL"):
                    return f"(-{code})", kind
                raise TypeError(f"{op} {kind}: {node}")
            case tree.BinaryOperation():
                return self.binary(node)
            case tree.FunctionCall():
                return self.call(node)
        return self.place(node)

    def binary(self, node):
        op = str(node.op).upper()
        (left, one), (right, other) = self.expression(node.left), self.expression(node.right)
        if op in ("AND", "OR"):
            if (one, other) != ("BOOL", "BOOL"):
                raise TypeError(f"{one} {op} {other}: {node}")
            # A PLC may evaluate both sides, so both are evaluated.
            return f"({left} {'&' if op == 'AND' else '|'} {right})", "BOOL"
        kind = other if one == "literal" else one if other == "literal" else wider(one, other)
        if "literal" in (one, other) and kind not in ("literal", "INT", "DINT"):
            raise TypeError(f"{one} {op} {other}: {node}")
        if op in ("=", "<>", "<", "<=", ">", ">="):
            return f"({left} {dict(zip(('=', '<>'), ('==', '!='))).get(op, op)} {right})", "BOOL"
        if kind == "REAL" and op in "+-*/":
            return f"real({left} {op} {right})", kind
        whole = {"/": "quotient({}, {})", "MOD": "remainder({}, {})"}.get(op, f"({{}} {op} {{}})")
        if kind not in ("INT", "DINT", "literal"):
            raise TypeError(f"{one} {op} {other}: {node}")
        code = whole.format(left, right)
        return (code if kind == "literal" else f"ranged({kind!r}, {code})"), kind

    def call(self, node):
        name = str(node.name.name).upper()
        (value,) = (one.value for one in node.parameters)
        while isinstance(value, tree.ParenthesizedExpression):
            value = value.expr
        if isinstance(value, (tree.MultiElementVariable, tree.Integer, tree.Real)):
            raise TypeError(f"{name} of {value}: assign it to a variable first")
        code, kind = self.expression(value)
        if name in ("EXP", "ABS") and kind == "REAL":
            return f"real({name.lower()}({code}))", "REAL"
        source, _, target = name.partition("_TO_")
        if kind != source or (source == "REAL" and target in RANGES):
            raise TypeError(f"{name} of {kind}: {node}")
        match target:
            case "REAL":
                return f"real(float({code}))", target
            case "INT" | "DINT" | "BYTE":
                return f"ranged({target!r}, {code})", target
        raise TypeError(name)


def parse(path):
    blocks = {}
    for result in blark.parse.parse(path):
        if result.exception is not None:
            raise result.exception
        for node in result.transform().items:
            blocks[str(node.name)] = Block(node)
    return blocks


def value(text, kind, is_array):
    if is_array:
        return list(bytes.fromhex(text))
    return {"REAL": lambda: real(float(text)), "BOOL": lambda: text == "1"}.get(kind, lambda: int(text))()


def text(value):
    if isinstance(value, list):
        return ",".join(text(one) for one in value)
    return str(int(value)) if isinstance(value, bool) else repr(value)


def main():
    blocks = {}
    for path in sys.argv[1:]:
        blocks.update(parse(path))
    print("ready", *blocks, flush=True)
    memory = {}
    for line in sys.stdin:
        name, instance, *settings = line.split()
        block = blocks[name]
        if (name, instance) not in memory:
            memory[name, instance] = {
                key: list(start) if isinstance(start, list) else start for key, start in block.start.items()
            }
        variables = memory[name, instance]
        for setting in settings:
            key, _, given = setting.partition("=")
            if key not in block.inputs:
                raise KeyError(key)
            variables[key] = value(given, block.types[key], key in block.arrays)
        block.run(variables)
        print(*(f"{key}={text(variables[key])}" for key in block.outputs), flush=True)


main()
