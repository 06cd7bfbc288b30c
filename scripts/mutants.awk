# Every change of one place that scripts/mutate.sh may make to a source file, one a line, in any order:
#   operator, file, line, column, length, what stands there instead     (separated by tabs)
# Portable awk. Variable `excluded` names the file of changes that are no mutants; see mutants_excluded.txt.

BEGIN {
  FS = "\t"
  while ((getline < excluded) > 0) {
    if ($0 ~ /^#/ || NF < 4) continue
    ++exclusions
    exclude_operator[exclusions] = $1
    exclude_file[exclusions] = $2
    exclude_code[exclusions] = $3
  }
  digits = "(0|[1-9][0-9]*)([.][0-9]+)?(e-?[0-9]+)?"
}

FNR == 1 { in_statement = in_comment = skipping = 0; before = "{" }

{
  code = code_of($0)
  if (skipping || code ~ /^ *(static_)?assert\(/) {  # what a failed assertion says is no behaviour
    skipping = code !~ /; *$/
  } else if (code ~ /[^ ]/ && code !~ /^ *(#|using |template |namespace |requires )/) {
    relations()
    arithmetic()
    constants()
    conditions()
    statements()
    functions()
  }
  if (code ~ /[^ ]/) before = code
}

# The line with comments and the inside of strings blanked, so that columns stay.
function code_of(line,    i, c, text, out) {
  out = ""
  text = 0
  for (i = 1; i <= length(line); ++i) {
    c = substr(line, i, 1)
    if (in_comment) {
      if (substr(line, i, 2) == "*/") { in_comment = 0; ++i; out = out " " }
      out = out " "
    } else if (text) {
      if (c == "\\") { ++i; out = out "_" }
      if (c == "\"") text = 0
      out = out "_"
    } else if (substr(line, i, 2) == "//") {
      break
    } else if (substr(line, i, 2) == "/*") {
      in_comment = 1
      out = out " "
    } else {
      if (c == "\"") { text = 1; c = "_" }
      out = out c
    }
  }
  sub(/ +$/, "", out)
  return out
}

function put(operator, column, size, instead,    k) {
  for (k = 1; k <= exclusions; ++k)
    if (operator ~ ("^(" exclude_operator[k] ")$") && FILENAME ~ exclude_file[k] && $0 ~ exclude_code[k]) return
  printf "%s\t%s\t%d\t%d\t%d\t%s\n", operator, FILENAME, FNR, column, size, instead
}

# Each place where `from` stands.
function swap(operator, from, to,    start, at) {
  for (start = 1; (at = index(substr(code, start), from)) > 0; start += at)
    put(operator, start + at - 1, length(from), to)
}

# Each place where `from` stands and no longer word ends with it.
function swap_word(operator, from, to,    start, at) {
  for (start = 1; (at = index(substr(code, start), from)) > 0; start += at)
    if (substr(" " code, start + at - 1, 1) !~ /[A-Za-z0-9_]/) put(operator, start + at - 1, length(from), to)
}

function relations() {
  swap("relation", " < ", " >= ")
  swap("relation", " > ", " <= ")
  swap("relation", " <= ", " > ")
  swap("relation", " >= ", " < ")
  swap("relation", " == ", " != ")
  swap("relation", " != ", " == ")
  swap("boundary", " < ", " <= ")
  swap("boundary", " > ", " >= ")
  swap("boundary", " <= ", " < ")
  swap("boundary", " >= ", " > ")
  swap("logic", " && ", " || ")
  swap("logic", " || ", " && ")
}

function arithmetic() {
  swap("arithmetic", " + ", " - ")
  swap("arithmetic", " - ", " + ")
  swap("arithmetic", " * ", " / ")
  swap("arithmetic", " / ", " * ")
  swap("arithmetic", " += ", " -= ")
  swap("arithmetic", " -= ", " += ")
  swap("arithmetic", " *= ", " /= ")
  swap("arithmetic", " /= ", " *= ")
  swap("arithmetic", "++", "--")
  swap("sign", "(-", "(")
  swap("sign", "{-", "{")
  swap("sign", "= -", "= ")
  swap("sign", ", -", ", ")
  swap("sign", "return -", "return ")
  swap("sign", "<< -", "<< ")
}

function constants(    start, value, next_char) {
  for (start = 1; match(substr(code, start), digits); start += RSTART + RLENGTH - 1) {
    value = substr(code, start + RSTART - 1, RLENGTH)
    next_char = substr(code, start + RSTART - 1 + RLENGTH, 1)
    if (substr(" " code, start + RSTART - 1, 1) ~ /[A-Za-z0-9_.']/ || next_char ~ /[A-Za-z0-9_.']/) continue
    if (value !~ /[.e]/) {
      put("constant", start + RSTART - 1, RLENGTH, value + 1)
    } else if (value + 0 == 0) {
      put("constant", start + RSTART - 1, RLENGTH, "1.0")
    } else {
      put("constant", start + RSTART - 1, RLENGTH, "(10.0 * " value ")")
      put("constant", start + RSTART - 1, RLENGTH, "(0.1 * " value ")")
    }
  }
}

# Where the parenthesis that opens at `from` closes on this line, else 0.
function closing(from,    i, c, depth) {
  for (i = from; i <= length(code); ++i) {
    c = substr(code, i, 1)
    if (c == "(") ++depth
    if (c == ")" && --depth == 0) return i
  }
  return 0
}

function conditions(    from, to) {
  if (!match(code, /(^|[ }])(if|while) \(/)) return
  from = RSTART + RLENGTH - 1
  to = closing(from)
  if (to > 0) put("negation", from + 1, to - from - 1, "!(" substr($0, from + 1, to - from - 1) ")")
}

function statements(    from, text, value) {
  match(code, /[^ ]/)
  from = RSTART
  text = substr(code, from)
  if (match(text, /(^|[ (])return [^;]+;$/)) {
    from += RSTART - 1 + (substr(text, RSTART, 1) ~ /[ (]/)
    value = substr(code, from + 7, length(code) - from - 7)
    if (value == "true") put("return", from + 7, 4, "false")
    else if (value == "false") put("return", from + 7, 5, "true")
    else if (value == "Status::ok") put("return", from + 7, length(value), "Status::indefinite")
    else if (value !~ /^([0{]|nullptr)/) put("return", from + 7, length(value), "{}")
    return
  }
  if (before !~ /[;{}:)]$|(^| )else$/) return  # goes on from the line before
  # A call, an assignment or a step, whole on its line: no declaration has a word for the first and no type.
  if (text ~ /^[a-z_][A-Za-z0-9_.:>()-]*(\[[^]]*\])?[A-Za-z0-9_.>()]*\(.*\);$/ && text !~ /^[a-z_:]+ / ||
      text ~ /^[a-z_][^ ]* [-+*\/|]?= .*;$/ || text ~ /^(\+\+|--)[^ ]+;$/ || text ~ /^(break|continue);$/)
    put("deletion", from, length(text), ";")
}

function functions() {
  swap("minmax", "std::min(", "std::max(")
  swap("minmax", "std::max(", "std::min(")
  swap("minmax", "std::min<", "std::max<")
  swap("minmax", "std::max<", "std::min<")
  swap("minmax", "cwiseMax(", "cwiseMin(")
  swap("minmax", "cwiseMin(", "cwiseMax(")
  swap("minmax", "minCoeff(", "maxCoeff(")
  swap("minmax", "maxCoeff(", "minCoeff(")
  swap("minmax", "ranges::min", "ranges::max")
  swap("minmax", "ranges::max", "ranges::min")
  swap_word("wrap", "wrap_angle(", "(")
  swap_word("wrap", "angle_difference(", "std::minus<>{}(")
  swap_word("function", "std::abs(", "(")
  swap_word("function", "std::sqrt(", "(")
  swap_word("function", "sin(", "cos(")
  swap_word("function", "cos(", "sin(")
  swap("function", ".transpose()", "")
}
