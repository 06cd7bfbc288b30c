#include "apps/keys/key_reference.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "apps/keys/units.h"

namespace leadline::app {

KeyReference::KeyReference() {
  parts_.push_back(
      {.path = {},
       .condition = {},
       .heading =
           "# Configuration\n\n"
           "One YAML file describes a run. Every key has a default; an unknown or doubled key, a wrong type "
           "and "
           "a value\n"
           "out of range are errors. `--set key.path=value` on the command line overrides the file and "
           "passes "
           "the same\n"
           "checks; elements of lists are counted from 0: `--set sensors.0.range_sigma_m=0.1`. Sigmas are "
           "standard\n"
           "deviations; those per sqrt(s) are random walks, which grow with the square root of time.\n\n"
           "This page is printed by `leadline reference`.\n\n"});
}

void KeyReference::number(std::string_view name, double& value, Limits allowed, const OptionText& text) {
  row(name, in_unit(value, text.unit), fmt::format("{} to {}", allowed.min, allowed.max), text);
}

void KeyReference::whole_number(std::string_view name, std::int64_t& value, Limits allowed,
                                const OptionText& text) {
  row(name, std::to_string(value),
      fmt::format("{} to {}", static_cast<std::int64_t>(allowed.min), static_cast<std::int64_t>(allowed.max)),
      text);
}

void KeyReference::flag(std::string_view name, bool& value, const OptionText& text) {
  row(name, value ? "true" : "false", "true, false", text);
}

void KeyReference::word(std::string_view name, std::string& value, Limits allowed, const OptionText& text) {
  row(name, value, fmt::format("{} to {} bytes", allowed.min, allowed.max), text);
}

void KeyReference::one_of(std::string_view name, std::size_t& index,
                          std::span<const std::string_view> options, const OptionText& text) {
  row(name, options[index], fmt::format("{}", fmt::join(options, ", ")), text);
}

void KeyReference::section(std::string_view name, std::string_view meaning,
                           const std::function<void()>& body) {
  enter(std::string(name), meaning, body);
}

void KeyReference::sections(std::string_view name, std::string_view meaning, std::size_t size,
                            const std::function<void(std::size_t)>& resize,
                            const std::function<void(std::size_t)>& body) {
  if (size == 0) resize(1);
  enter(std::string(name) + ".N", meaning, [&] { body(0); });
}

void KeyReference::only(std::string_view condition, bool, const std::function<void()>& body) {
  condition_ = condition;
  body();
  condition_.clear();
}

void KeyReference::alternative(std::string_view name, bool, const std::function<void()>& body) {
  alternative_ = name;
  body();
  alternative_.clear();
}

void KeyReference::defaults(const std::function<void()>& assign, std::span<const DefaultText> texts) {
  assign();
  for (const DefaultText& text : texts)
    default_texts_.emplace_back(path_ + std::string(text.option), text.words);
}

std::string KeyReference::take() && {
  std::string page;
  for (const Part& part : parts_) {
    page += part.heading;
    if (part.rows.empty()) continue;
    page += "| key | unit | default | allowed | meaning |\n|---|---|---|---|---|\n";
    for (const Row& row : part.rows)
      fmt::format_to(std::back_inserter(page), "| `{}` | {} | {} | {} | {}{}{} |\n", row.name, row.unit,
                     row.default_value, row.allowed, row.meaning, row.alternatives.empty() ? "" : "; ",
                     fmt::join(row.alternatives, ", "));
    page += "\n";
  }
  page.pop_back();
  return page;
}

void KeyReference::row(std::string_view name, std::string_view default_value, std::string_view allowed,
                       const OptionText& text) {
  std::vector<Row>& rows = parts_[part_].rows;
  auto row = std::ranges::find_if(
      rows, [&](const Row& known) { return known.name == name && known.condition == condition_; });
  if (row == rows.end()) {
    const bool top_of_condition = !condition_.empty() && path_.find('.') == path_.size() - 1;
    row = rows.insert(row, {.name = std::string(name),
                            .unit = std::string(text.unit),
                            .default_value = shown_default(name, default_value),
                            .allowed = std::string(allowed),
                            .meaning = (top_of_condition ? fmt::format("({}) ", condition_) : "") +
                                       std::string(text.meaning),
                            .condition = condition_});
  }
  if (!alternative_.empty()) row->alternatives.push_back(alternative_);
}

std::string KeyReference::shown_default(std::string_view name, std::string_view value) const {
  const auto text = std::ranges::find(default_texts_, path_ + std::string(name),
                                      &std::pair<std::string, std::string>::first);
  if (text == default_texts_.end()) return std::string(value.empty() ? "none" : value);
  return text->second + (text->second.ends_with("else") ? fmt::format(" {}", value) : "");
}

void KeyReference::enter(const std::string& name, std::string_view meaning,
                         const std::function<void()>& body) {
  const std::size_t outer_part = part_;
  const std::string outer_path = std::exchange(path_, path_ + name + ".");
  const auto same = [&](const Part& part) { return part.path == path_ && part.condition == condition_; };
  part_ = static_cast<std::size_t>(std::ranges::find_if(parts_, same) - parts_.begin());
  if (part_ == parts_.size())
    parts_.push_back(
        {.path = path_,
         .condition = condition_,
         .heading = fmt::format("## {}\n\n{}{}\n\n", path_.substr(0, path_.size() - 1), meaning,
                                condition_.empty() ? "" : fmt::format(" Only with `{}`.", condition_))});
  body();
  part_ = outer_part;
  path_ = outer_path;
}

}  // namespace leadline::app
