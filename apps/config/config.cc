#include "apps/config/config.h"

#include <fmt/format.h>

#include <stdexcept>
#include <utility>

#include "apps/config/config_keys.h"
#include "apps/keys/key_reader.h"
#include "apps/keys/key_reference.h"
#include "apps/keys/key_writer.h"
#include "apps/keys/yaml_tree.h"
#include "apps/support/usage_error.h"

namespace leadline::app {

Setting Setting::parse(const std::string& text) {
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos || equals == 0)
    throw UsageError(fmt::format("--set {}: must be key.path=value", text));
  return {text.substr(0, equals), text.substr(equals + 1), "--set " + text};
}

Config read_config(const std::filesystem::path& path, const std::vector<Setting>& settings) {
  YamlTree tree = read_yaml(path);
  for (const Setting& setting : settings) set_yaml(tree, setting.key, setting.value, setting.option);
  Config config;
  config.name = path.stem().string();
  KeyReader reader(tree);
  declare(reader, config);
  reader.finish();
  return config;
}

nlohmann::ordered_json to_json(const Config& config) {
  Config copy = config;
  KeyWriter writer;
  declare(writer, copy);
  return std::move(writer).take();
}

std::string config_reference() {
  Config defaults;
  defaults.slam.sensors.resize(1);
  KeyReference reference;
  declare(reference, defaults);
  return std::move(reference).take();
}

std::string_view name(Filter filter) {
  switch (filter) {
    case Filter::ekf:
      return "ekf";
    case Filter::ukf:
      return "ukf";
    case Filter::ukf_paper:
      return "ukf_paper";
    case Filter::iplf:
      break;
  }
  return "iplf";
}
std::string_view name(Map map) { return map == Map::submaps ? "submaps" : "global"; }
std::string_view name(ErrorKind error) { return error == ErrorKind::additive ? "additive" : "invariant"; }

}  // namespace leadline::app
