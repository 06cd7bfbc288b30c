#include "apps/keys/key_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <utility>

#include "apps/keys/units.h"

namespace leadline::app {
namespace {

std::string between(Limits allowed) { return fmt::format("from {} to {}", allowed.min, allowed.max); }

template <class T>
std::optional<T> parse(const YamlTree& value) {
  T result{};
  const char *begin = value.scalar.data(), *end = begin + value.scalar.size();
  const auto [stop, error] = std::from_chars(begin, end, result);
  if (value.quoted || error != std::errc() || stop != end) return std::nullopt;
  return result;
}

std::string quoted_list(std::span<const std::string_view> options) {
  return fmt::format("{}", fmt::join(options, ", "));
}

/// Number of letters to change, insert or leave out to make one of the other (Levenshtein).
std::size_t distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) row[j] = j;
  for (std::size_t i = 0; i < a.size(); ++i) {
    std::size_t diagonal = std::exchange(row[0], i + 1);
    for (std::size_t j = 0; j < b.size(); ++j) {
      const std::size_t changed = diagonal + (a[i] == b[j] ? 0 : 1);
      diagonal = std::exchange(row[j + 1], std::min({changed, row[j] + 1, row[j + 1] + 1}));
    }
  }
  return row.back();
}

}  // namespace

KeyReader::KeyReader(const YamlTree& root) {
  if (root.kind != YamlTree::Kind::map && root.kind != YamlTree::Kind::null)
    root.place.fail(fmt::format("the configuration is {}, must be a section of keys", describe(root)));
  levels_.push_back({.node = &root, .path = "", .place = root.place});
}

void KeyReader::number(std::string_view name, double& value, Limits allowed, const OptionText& text) {
  const YamlTree* found = find_scalar(name, in_unit(value, text.unit), "a number, " + between(allowed));
  if (!found) return;
  const auto read = parse<double>(*found);
  if (!read || !std::isfinite(*read)) refuse(*found, name, "a finite number, " + between(allowed));
  if (!allowed.contain(*read)) refuse(*found, name, between(allowed));
  value = from_unit(*read, text.unit);
}

void KeyReader::whole_number(std::string_view name, std::int64_t& value, Limits allowed, const OptionText&) {
  const YamlTree* found = find_scalar(name, std::to_string(value), "a whole number, " + between(allowed));
  if (!found) return;
  const auto read = parse<std::int64_t>(*found);
  if (!read) refuse(*found, name, "a whole number, " + between(allowed));
  if (!allowed.contain(static_cast<double>(*read))) refuse(*found, name, between(allowed));
  value = *read;
}

void KeyReader::flag(std::string_view name, bool& value, const OptionText&) {
  const YamlTree* found = find_scalar(name, value ? "true" : "false", "true or false");
  if (!found) return;
  const bool yes = found->scalar == "true", no = found->scalar == "false";
  if (found->quoted || (!yes && !no)) refuse(*found, name, "true or false");
  value = yes;
}

void KeyReader::word(std::string_view name, std::string& value, Limits allowed, const OptionText&) {
  const std::string what = fmt::format("a text of {} to {} bytes", allowed.min, allowed.max);
  const YamlTree* found = find_scalar(name, value, what);
  if (!found) return;
  if (!allowed.contain(static_cast<double>(found->scalar.size()))) refuse(*found, name, what);
  value = found->scalar;
}

void KeyReader::one_of(std::string_view name, std::size_t& index, std::span<const std::string_view> options,
                       const OptionText&) {
  const std::string what = "one of " + quoted_list(options);
  const YamlTree* found = find_scalar(name, std::string(options[index]), what);
  if (!found) return;
  const auto option = std::ranges::find(options, found->scalar);
  if (option == options.end()) refuse(*found, name, what);
  index = static_cast<std::size_t>(option - options.begin());
}

void KeyReader::section(std::string_view name, std::string_view, const std::function<void()>& body) {
  const YamlTree* found = find(name, "");
  if (!condition_.empty()) return;
  if (found && found->kind != YamlTree::Kind::map && found->kind != YamlTree::Kind::null)
    refuse(*found, name, "a section of keys");
  enter(name, found, body);
}

void KeyReader::sections(std::string_view name, std::string_view, std::size_t,
                         const std::function<void(std::size_t)>& resize,
                         const std::function<void(std::size_t)>& body) {
  const YamlTree* found = find(name, "an empty list");
  if (!found) return;
  if (found->kind != YamlTree::Kind::list) refuse(*found, name, "a list of sections");
  resize(found->entries.size());
  for (std::size_t i = 0; i < found->entries.size(); ++i) {
    const YamlTree& item = found->entries[i].value;
    const std::string item_name = fmt::format("{}.{}", name, i);
    if (item.kind != YamlTree::Kind::map) refuse(item, item_name, "a section of keys");
    enter(item_name, &item, [&] { body(i); });
  }
}

void KeyReader::only(std::string_view condition, bool holds, const std::function<void()>& body) {
  if (!holds) condition_ = condition;
  body();
  condition_.clear();
}

void KeyReader::alternative(std::string_view, bool, const std::function<void()>& body) { body(); }

void KeyReader::defaults(const std::function<void()>& assign, std::span<const DefaultText>) { assign(); }

void KeyReader::require(bool holds, std::string_view name, std::string_view allowed) {
  if (holds || !condition_.empty()) return;
  const Level& level = levels_.back();
  if (const YamlTree* value = level.node ? level.node->find(name) : nullptr) refuse(*value, name, allowed);
  const auto known = std::ranges::find(level.known, name, &Known::name);
  level.place.fail(fmt::format("{}{} is not given ({}), must be {}", level.path, name,
                               known->value.empty() ? "there is no default" : "default " + known->value,
                               allowed));
}

const YamlTree* KeyReader::find(std::string_view name, std::string default_value) {
  Level& level = levels_.back();
  level.known.push_back({std::string(name), std::move(default_value), condition_});
  return level.node && condition_.empty() ? level.node->find(name) : nullptr;
}

const YamlTree* KeyReader::find_scalar(std::string_view name, std::string default_value,
                                       std::string_view allowed) {
  const YamlTree* found = find(name, std::move(default_value));
  if (found && found->kind != YamlTree::Kind::scalar) refuse(*found, name, allowed);
  return found;
}

void KeyReader::enter(std::string_view name, const YamlTree* node, const std::function<void()>& body) {
  levels_.push_back(open(fmt::format("{}{}.", levels_.back().path, name), node));
  body();
  Level read = std::move(levels_.back());
  levels_.pop_back();
  if (levels_.size() == 1) {
    refuse_unknown(read);
  } else {
    levels_.back().inner.push_back(std::move(read));
  }
}

KeyReader::Level KeyReader::open(std::string path, const YamlTree* node) {
  Level& outer = levels_.back();
  const auto begun = std::ranges::find(outer.inner, path, &Level::path);
  if (begun == outer.inner.end()) {
    YamlPlace place = node ? node->place : outer.place;
    return {.node = node, .path = std::move(path), .place = std::move(place)};
  }
  Level level = std::move(*begun);
  outer.inner.erase(begun);
  return level;
}

void KeyReader::refuse_unknown(const Level& level) {
  for (const Level& inner : level.inner) refuse_unknown(inner);
  if (!level.node) return;
  for (const YamlTree::Entry& entry : level.node->entries) {
    const auto meant = std::ranges::find(level.known, entry.name, &Known::name);
    if (meant == level.known.end()) {
      for (const auto& [name, why] : level.gone)
        if (name == entry.name)
          entry.place.fail(fmt::format("{}{} is no longer a key: {}", level.path, name, why));
      const auto nearest = std::ranges::min_element(
          level.known, {}, [&](const Known& known) { return distance(known.name, entry.name); });
      entry.place.fail(fmt::format("unknown key {}{}, did you mean {}{}?", level.path, entry.name, level.path,
                                   nearest->name));
    }
    // A key may mean something under more than one condition.
    const auto means = [&](const Known& known) {
      return known.name == entry.name && known.condition.empty();
    };
    if (std::ranges::none_of(level.known, means))
      entry.place.fail(fmt::format("{}{} is only allowed with {}", level.path, entry.name, meant->condition));
  }
}

void KeyReader::gone(std::string_view name, std::string_view why) {
  levels_.back().gone.emplace_back(name, why);
}

void KeyReader::refuse(const YamlTree& value, std::string_view name, std::string_view allowed) const {
  value.place.fail(
      fmt::format("{}{} is {}, must be {}", levels_.back().path, name, describe(value), allowed));
}

}  // namespace leadline::app
