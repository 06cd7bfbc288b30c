# Sourced. stage TITLE COMMAND...: prints a heading, runs the command and prints how long it took.
stage() {
  local title="$1" start=$SECONDS
  shift
  printf '\n== %s\n' "$title"
  "$@"
  printf '== %s: %d s\n' "$title" $((SECONDS - start))
}
