#include "apps/keys/yaml_tree.h"

#include <fmt/format.h>
#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/exceptions.h>
#include <yaml-cpp/parser.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <functional>
#include <sstream>
#include <stdexcept>
#include <utility>

#include "apps/support/usage_error.h"

namespace leadline::app {
namespace {

constexpr std::uintmax_t kMaxFileSize = 1 << 20;

using Places = std::function<YamlPlace(const YAML::Mark&)>;

YamlTree make_node(YamlTree::Kind kind, YamlPlace place) {
  YamlTree node;
  node.kind = kind;
  node.place = std::move(place);
  return node;
}

/// Makes a tree of the parser's events.
class Builder final : public YAML::EventHandler {
 public:
  explicit Builder(Places places) : places_(std::move(places)) {}

  YamlTree take() && { return std::move(root_); }

  void OnDocumentStart(const YAML::Mark&) override {}
  void OnDocumentEnd() override {}

  void OnNull(const YAML::Mark& mark, YAML::anchor_t) override {
    add(make_node(YamlTree::Kind::null, places_(mark)));
  }

  void OnAlias(const YAML::Mark& mark, YAML::anchor_t) override {
    places_(mark).fail("an alias (*name) is not allowed here");
  }

  void OnScalar(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t,
                const std::string& value) override {
    YamlTree node = make_node(YamlTree::Kind::scalar, places_(mark));
    node.scalar = value;
    node.quoted = tag == "!";
    add(std::move(node));
  }

  void OnSequenceStart(const YAML::Mark& mark, const std::string&, YAML::anchor_t,
                       YAML::EmitterStyle::value) override {
    open_.push_back({.node = make_node(YamlTree::Kind::list, places_(mark))});
  }
  void OnMapStart(const YAML::Mark& mark, const std::string&, YAML::anchor_t,
                  YAML::EmitterStyle::value) override {
    open_.push_back({.node = make_node(YamlTree::Kind::map, places_(mark))});
  }
  void OnSequenceEnd() override { close(); }
  void OnMapEnd() override { close(); }

 private:
  struct Open {
    YamlTree node;
    bool has_key = false;  // the next value belongs to this key
    std::string key = {};
    YamlPlace key_place = {};
  };

  void close() {
    YamlTree node = std::move(open_.back().node);
    open_.pop_back();
    add(std::move(node));
  }

  void add(YamlTree value) {
    if (open_.empty()) {
      root_ = std::move(value);
      return;
    }
    Open& parent = open_.back();
    std::vector<YamlTree::Entry>& entries = parent.node.entries;
    if (parent.node.kind == YamlTree::Kind::list) {
      YamlPlace place = value.place;
      entries.push_back({std::to_string(entries.size()), std::move(place), std::move(value)});
    } else if (parent.has_key) {
      entries.push_back({std::move(parent.key), std::move(parent.key_place), std::move(value)});
      parent.has_key = false;
    } else {
      if (value.kind != YamlTree::Kind::scalar)
        value.place.fail(fmt::format("{} is not a key", describe(value)));
      if (const auto twin = std::ranges::find(entries, value.scalar, &YamlTree::Entry::name);
          twin != entries.end())
        value.place.fail(
            fmt::format("key '{}' stands here twice, first at {}", value.scalar, twin->place.text));
      parent.key = value.scalar;
      parent.key_place = value.place;
      parent.has_key = true;
    }
  }

  Places places_;
  YamlTree root_;
  std::vector<Open> open_;
};

YamlTree parse(std::istream& text, const Places& places) {
  Builder builder(places);
  try {
    YAML::Parser parser(text);
    parser.HandleNextDocument(builder);
    Builder rest(places);
    if (parser.HandleNextDocument(rest)) {
      std::move(rest).take().place.fail("a second document begins, must be one");
    }
  } catch (const YAML::Exception& error) {
    places(error.mark).fail(error.msg);
  }
  return std::move(builder).take();
}

}  // namespace

void YamlPlace::fail(std::string_view message) const {
  const std::string whole = fmt::format("{}: {}", text, message);
  if (command_line) throw UsageError(whole);
  throw std::runtime_error(whole);
}

YamlTree* YamlTree::find(std::string_view name) {
  const auto found = std::ranges::find(entries, name, &Entry::name);
  return found == entries.end() ? nullptr : &found->value;
}

const YamlTree* YamlTree::find(std::string_view name) const {
  return const_cast<YamlTree*>(this)->find(name);
}

std::string describe(const YamlTree& value) {
  constexpr std::size_t kLongest = 60;
  const std::string_view quote = value.quoted ? "\"" : "";
  switch (value.kind) {
    case YamlTree::Kind::scalar:
      return fmt::format("{}{}{}{}", quote, value.scalar.substr(0, kLongest),
                         value.scalar.size() > kLongest ? "..." : "", quote);
    case YamlTree::Kind::map:
      return "a section";
    case YamlTree::Kind::list:
      return value.entries.empty() ? "an empty list" : "a list";
    case YamlTree::Kind::null:
      break;
  }
  return "empty";
}

YamlTree read_yaml(const std::filesystem::path& path) {
  const auto fail = [&](std::string_view reason) {
    throw std::runtime_error(fmt::format("{}: {}", path.string(), reason));
  };
  std::ifstream file(path, std::ios::binary);
  if (!file) fail(std::strerror(errno));
  std::string text(kMaxFileSize + 1, '\0');
  errno = 0;
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (file.bad() || errno != 0) fail(std::strerror(errno));
  if (file.gcount() > static_cast<std::streamsize>(kMaxFileSize))
    fail("larger than 1 MiB, which no configuration is");
  text.resize(static_cast<std::size_t>(file.gcount()));

  std::istringstream stream(std::move(text));
  YamlTree root = parse(stream, [&](const YAML::Mark& mark) {
    return YamlPlace{fmt::format("{}:{}", path.string(), mark.line + 1), false};
  });
  if (root.place.text.empty()) root.place.text = path.string();
  return root;
}

void set_yaml(YamlTree& root, std::string_view key, const std::string& value, std::string_view option) {
  YamlPlace place{std::string(option), true};
  std::istringstream stream(value);
  YamlTree node = parse(stream, [&](const YAML::Mark&) { return place; });
  node.place = place;

  YamlTree* target = &root;
  for (std::string_view rest = key; !rest.empty();) {
    const std::string_view name = rest.substr(0, rest.find('.'));
    rest.remove_prefix(std::min(name.size() + 1, rest.size()));
    if (target->kind == YamlTree::Kind::null) target->kind = YamlTree::Kind::map;
    if (YamlTree* next = target->find(name)) {
      target = next;
      continue;
    }
    if (target->kind == YamlTree::Kind::list)
      place.fail(fmt::format("there is no element '{}', the list has {}, counted from 0", name,
                             target->entries.size()));
    if (target->kind != YamlTree::Kind::map)
      place.fail(fmt::format("there is no '{}' in {}, which is not a section", name, describe(*target)));
    target->entries.push_back({std::string(name), place, make_node(YamlTree::Kind::null, place)});
    target = &target->entries.back().value;
  }
  *target = std::move(node);
}

}  // namespace leadline::app
