#include "apps/keys/key_writer.h"

#include "apps/keys/units.h"

namespace leadline::app {

void KeyWriter::number(std::string_view name, double& value, Limits, const OptionText& text) {
  json_[std::string(name)] = std::stod(in_unit(value, text.unit));
}

void KeyWriter::whole_number(std::string_view name, std::int64_t& value, Limits, const OptionText&) {
  json_[std::string(name)] = value;
}

void KeyWriter::flag(std::string_view name, bool& value, const OptionText&) {
  json_[std::string(name)] = value;
}

void KeyWriter::word(std::string_view name, std::string& value, Limits, const OptionText&) {
  json_[std::string(name)] = value;
}

void KeyWriter::one_of(std::string_view name, std::size_t& index, std::span<const std::string_view> options,
                       const OptionText&) {
  json_[std::string(name)] = options[index];
}

void KeyWriter::section(std::string_view name, std::string_view, const std::function<void()>& body) {
  nlohmann::ordered_json& begun = json_[std::string(name)];
  nlohmann::ordered_json section = begun.is_null() ? nlohmann::ordered_json::object() : std::move(begun);
  nlohmann::ordered_json outer = std::exchange(json_, std::move(section));
  body();
  outer[std::string(name)] = std::exchange(json_, nullptr);
  json_ = std::move(outer);
}

void KeyWriter::sections(std::string_view name, std::string_view, std::size_t size,
                         const std::function<void(std::size_t)>&,
                         const std::function<void(std::size_t)>& body) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (std::size_t i = 0; i < size; ++i) {
    nlohmann::ordered_json outer = std::exchange(json_, nlohmann::ordered_json::object());
    body(i);
    list.push_back(std::exchange(json_, std::move(outer)));
  }
  json_[std::string(name)] = std::move(list);
}

void KeyWriter::alternative(std::string_view, bool in_use, const std::function<void()>& body) {
  if (in_use) body();
}

void KeyWriter::only(std::string_view, bool holds, const std::function<void()>& body) {
  if (holds) body();
}

}  // namespace leadline::app
