#include "apps/maps/map_file.h"

#include <fmt/format.h>

#include <array>
#include <bit>
#include <boost/crc.hpp>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <functional>
#include <iterator>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>

#include "apps/support/atomic_file.h"
#include "apps/support/limits.h"
#include "apps/support/overloaded.h"

namespace leadline::app {
namespace {

using nlohmann::json;

constexpr std::string_view kMagic = "leadline map\n";
constexpr std::size_t kHeaderSize = kMagic.size() + 4 + 8 + 4;  // version, length, CRC-32

static_assert(std::endian::native == std::endian::little, "numbers are stored as they lie in memory");

template <class T>
void append(const T& value, std::vector<std::byte>& bytes) {
  const auto raw = std::as_bytes(std::span(&value, 1));
  bytes.insert(bytes.end(), raw.begin(), raw.end());
}

template <class T>
T take(std::span<const std::byte>& bytes) {
  T value;
  std::memcpy(&value, bytes.data(), sizeof value);
  bytes = bytes.subspan(sizeof value);
  return value;
}

std::uint32_t crc_of(std::span<const std::byte> bytes) {
  boost::crc_32_type crc;
  crc.process_bytes(bytes.data(), bytes.size());
  return crc.checksum();
}

[[noreturn]] void refuse(std::string_view what) { throw std::runtime_error(std::string(what)); }

/// Walks through a document and stops where it is nested deeper than any map: a parser that builds it calls
/// itself for every level.
class DepthGuard final : public nlohmann::json_sax<json> {
 public:
  bool too_deep() const { return depth_ > kMaxDepth; }

  bool start_object(std::size_t) override { return enter(); }
  bool start_array(std::size_t) override { return enter(); }
  bool end_object() override { return leave(); }
  bool end_array() override { return leave(); }
  bool null() override { return true; }
  bool boolean(bool) override { return true; }
  bool number_integer(std::int64_t) override { return true; }
  bool number_unsigned(std::uint64_t) override { return true; }
  bool number_float(double, const std::string&) override { return true; }
  bool string(std::string&) override { return true; }
  bool binary(json::binary_t&) override { return true; }
  bool key(std::string&) override { return true; }
  bool parse_error(std::size_t, const std::string&, const json::exception&) override { return false; }

 private:
  static constexpr int kMaxDepth = 16;

  bool enter() {
    ++depth_;
    return !too_deep();
  }
  bool leave() {
    --depth_;
    return true;
  }

  int depth_ = 0;
};

json parse(std::span<const std::byte> cbor) {
  const auto* begin = reinterpret_cast<const std::uint8_t*>(cbor.data());
  const auto* end = begin + cbor.size();
  DepthGuard guard;
  json::sax_parse(begin, end, &guard, json::input_format_t::cbor);
  if (guard.too_deep()) refuse("is not as a map must be: nested too deeply");
  return json::from_cbor(begin, end);
}

// Numbers by the thousand go as they are; CBOR's own arrays would take a tag for each.
json binary(std::span<const double> values) {
  const auto raw = std::as_bytes(values);
  const auto* begin = reinterpret_cast<const std::uint8_t*>(raw.data());
  return json::binary({begin, begin + raw.size()});
}

std::vector<double> numbers(const json& stored) {
  const auto& raw = stored.get_binary();
  if (raw.size() % sizeof(double) != 0) refuse("holds a part of a number");
  std::vector<double> values(raw.size() / sizeof(double));
  if (!raw.empty()) std::memcpy(values.data(), raw.data(), raw.size());
  return values;
}

/// @p size numbers.
std::vector<double> numbers(const json& stored, std::size_t size) {
  std::vector<double> values = numbers(stored);
  if (values.size() != size)
    refuse(fmt::format("holds {} numbers where there must be {}", values.size(), size));
  return values;
}

// JSON's own conversion takes every number for a whole one.
std::int64_t whole(const json& stored, Limits allowed) {
  if (!stored.is_number_integer() || !allowed.contain(stored.get<double>()))
    refuse(fmt::format("holds {} where there must be a whole number from {} to {}",
                       stored.dump().substr(0, 30), allowed.min, allowed.max));
  return stored.get<std::int64_t>();
}

template <class E>
E enumerator(const json& stored, E last) {
  return static_cast<E>(whole(stored, {0, static_cast<double>(last)}));
}

int identity(const json& stored) {
  using Int = std::numeric_limits<int>;
  return static_cast<int>(whole(stored, {Int::min(), Int::max()}));
}

json encode(const UncertainPose& pose) {
  std::vector<double> values{pose.X.x, pose.X.y, pose.X.heading};
  values.insert(values.end(), pose.P.data(), pose.P.data() + pose.P.size());
  return binary(values);
}

UncertainPose decode_pose(const json& stored) {
  const std::vector<double> values = numbers(stored, 12);
  UncertainPose pose;
  pose.X = {values[0], values[1], values[2]};
  pose.P = Eigen::Map<const Eigen::Matrix3d>(values.data() + 3);
  return pose;
}

json encode(const Joint& joint) {
  json parts = json::array();
  for (const Joint::Part& part : joint.parts())
    parts.push_back({static_cast<int>(part.key.kind), part.key.id,
                     binary({part.value.data(), static_cast<std::size_t>(part.size())})});
  std::vector<double> triangle;
  const Eigen::MatrixXd& P = joint.covariance();
  for (Eigen::Index i = 0; i < P.rows(); ++i)
    for (Eigen::Index j = 0; j <= i; ++j) triangle.push_back(P(i, j));
  return {{"parts", std::move(parts)}, {"covariance", binary(triangle)}};
}

bool is_size(Key::Kind kind, std::size_t size) {
  if (kind == Key::Kind::vehicle || kind == Key::Kind::gate) return size >= 3 && size <= Belief::kMaxVehicle;
  const auto usual = static_cast<std::size_t>(entries(kind));
  const bool may_have_radius = kind == Key::Kind::point || kind == Key::Kind::white_point;
  return size == usual || (may_have_radius && size == usual + 1);
}

Joint decode_joint(const json& stored) {
  std::vector<Joint::Part> parts;
  std::size_t n = 0;
  for (const json& part : stored.at("parts")) {
    const Key key{enumerator(part.at(0), Key::Kind::gate), identity(part.at(1))};
    const std::vector<double> value = numbers(part.at(2));
    if (!is_size(key.kind, value.size())) refuse(fmt::format("holds a part of {} numbers", value.size()));
    parts.push_back(
        {key, Eigen::Map<const Eigen::VectorXd>(value.data(), static_cast<Eigen::Index>(value.size()))});
    n += value.size();
  }
  const std::vector<double> triangle = numbers(stored.at("covariance"), n * (n + 1) / 2);
  const auto size = static_cast<Eigen::Index>(n);
  Eigen::MatrixXd P(size, size);
  auto next = triangle.begin();
  for (Eigen::Index i = 0; i < size; ++i)
    for (Eigen::Index j = 0; j <= i; ++j) P(i, j) = P(j, i) = *next++;
  return {std::move(parts), std::move(P)};
}

json encode(const Evidence& e) {
  return {e.log_point,         e.log_wall,          e.log_wall_rough,  e.point_pings.missed,
          e.point_pings.heard, e.wall_pings.missed, e.wall_pings.heard};
}

Evidence decode_evidence(const json& stored) {
  const auto value = [&](std::size_t i) { return stored.at(i).get<double>(); };
  return {value(0), value(1), value(2), {value(3), value(4)}, {value(5), value(6)}};
}

json encode(const std::vector<Channel>& channels) {
  json list = json::array();
  for (const Channel& c : channels)
    list.push_back({c.pings.missed,
                    c.pings.heard,
                    c.walls.echoes,
                    c.walls.sum,
                    c.walls.weight,
                    c.cross_talk.copies,
                    c.cross_talk.pings,
                    c.multipath.copies,
                    c.multipath.pings,
                    c.unexplained.returns,
                    c.unexplained.ranges,
                    c.unexplained.pings,
                    c.common.sum,
                    c.common.weight,
                    c.births.kept,
                    c.births.gone,
                    c.view.farthest,
                    c.view.from,
                    c.view.to,
                    c.view.looks.missed,
                    c.view.looks.heard,
                    c.feature,
                    c.turned});
  return list;
}

std::vector<Channel> decode_channels(const json& stored) {
  std::vector<Channel> channels;
  for (const json& entry : stored) {
    const auto value = [&](std::size_t i) { return entry.at(i).get<double>(); };
    channels.push_back({{value(0), value(1)},
                        {value(2), value(3), value(4)},
                        {value(5), value(6)},
                        {value(7), value(8)},
                        {value(9), value(10), value(11)},
                        {value(12), value(13)},
                        {value(14), value(15)},
                        {value(16), value(17), value(18), {value(19), value(20)}},
                        identity(entry.at(21)),
                        value(22)});
  }
  return channels;
}

/// A time before the last step, which a clock that was set may have carried beyond what any stamp is [us].
std::int64_t past(std::int64_t utime) {
  return std::clamp(utime, static_cast<std::int64_t>(limits::kTime.min),
                    static_cast<std::int64_t>(limits::kTime.max));
}

json encode(const std::vector<FirstReturn>& returns) {
  json list = json::array();
  for (const FirstReturn& first : returns)
    list.push_back({first.echo.x(), first.echo.y(), first.sensor, past(first.utime)});
  return list;
}

json encode(const Existence& e) {
  const Existence::Passage& p = e.passage;
  return {e.log_odds, e.misses, past(e.last_missed), e.passages, p.sensor, past(p.utime), p.from,
          p.to,       p.share};
}

Existence decode_existence(const json& stored) {
  Existence e;
  e.log_odds = stored.at(0).get<double>();
  e.misses = identity(stored.at(1));
  e.last_missed = whole(stored.at(2), limits::kTime);
  e.passages = identity(stored.at(3));
  e.passage = {identity(stored.at(4)), whole(stored.at(5), limits::kTime), stored.at(6).get<double>(),
               stored.at(7).get<double>(), stored.at(8).get<double>()};
  return e;
}

json encode(const std::vector<Alias>& aliases) {
  json list = json::array();
  for (const auto& [lost, kept] : aliases) list.push_back({lost, kept});
  return list;
}

constexpr std::array kPointShapes{std::pair(TargetShape::point, "point"),
                                  std::pair(TargetShape::circle, "circle"),
                                  std::pair(TargetShape::scaled, "scaled")};

std::string_view word(TargetShape shape) {
  return std::ranges::find(kPointShapes, shape, &decltype(kPointShapes)::value_type::first)->second;
}

TargetShape decode_point_shape(const json& entry) {
  if (!entry.contains("point_shape"))  // as maps were before there were scales
    return entry.value("has_radius", false) ? TargetShape::circle : TargetShape::point;
  const auto name = entry.at("point_shape").get<std::string>();
  const auto known = std::ranges::find(kPointShapes, name, &decltype(kPointShapes)::value_type::second);
  if (known == kPointShapes.end()) refuse(fmt::format("holds a feature of shape '{}'", name));
  return known->first;
}

json encode(const std::vector<Feature>& features) {
  json list = json::array();
  for (const Feature& f : features) {
    list.push_back({{"id", f.id},
                    {"kind", static_cast<int>(f.kind)},
                    {"confirmed", f.confirmed},
                    {"hits", f.hits},
                    {"point_shape", word(f.point_shape)},
                    {"given_up", f.given_up},
                    {"existence", encode(f.existence)},
                    {"sensor", f.sensor},
                    {"evidence", encode(f.evidence)},
                    {"seen", {f.seen.from, f.seen.to}},
                    {"farthest", f.farthest},
                    {"last_seen", past(f.last_seen)},
                    {"label", f.label},
                    {"label_lead", f.label_lead},
                    {"others", f.others}});
  }
  return list;
}

std::vector<Feature> decode_features(const json& stored) {
  std::vector<Feature> features;
  for (const json& entry : stored) {
    Feature& f = features.emplace_back();
    f.id = identity(entry.at("id"));
    f.kind = enumerator(entry.at("kind"), FeatureKind::wall);
    f.confirmed = entry.at("confirmed").get<bool>();
    f.hits = identity(entry.at("hits"));
    f.point_shape = decode_point_shape(entry);
    f.given_up = entry.at("given_up").get<bool>();
    f.existence = decode_existence(entry.at("existence"));
    f.sensor = identity(entry.at("sensor"));
    f.evidence = decode_evidence(entry.at("evidence"));
    f.seen = {entry.at("seen").at(0).get<double>(), entry.at("seen").at(1).get<double>()};
    f.farthest = entry.at("farthest").get<double>();
    f.last_seen = whole(entry.at("last_seen"), limits::kTime);
    f.label = identity(entry.at("label"));
    f.label_lead = static_cast<int>(whole(entry.at("label_lead"), {0, std::numeric_limits<int>::max()}));
    for (std::size_t k = 0; k < f.others.size(); ++k) f.others[k] = identity(entry.at("others").at(k));
  }
  return features;
}

json encode(const Submap& submap) {
  json gates = json::array();
  for (const auto& [id, neighbour] : submap.gates()) gates.push_back({id, neighbour});
  return {{"parent", submap.parent()},
          {"root", submap.root()},
          {"centre", {submap.centre().x(), submap.centre().y()}},
          {"visits", submap.visits()},
          {"gates", std::move(gates)},
          {"features", encode(submap.features())},
          {"joint", encode(submap.thaw())}};
}

Submap decode_submap(const json& stored, int id) {
  const json& centre = stored.at("centre");
  Submap submap(id, identity(stored.at("parent")), identity(stored.at("root")),
                {centre.at(0).get<double>(), centre.at(1).get<double>()}, identity(stored.at("visits")));
  std::vector<Submap::Gate> gates;
  for (const json& gate : stored.at("gates")) gates.push_back({identity(gate.at(0)), identity(gate.at(1))});
  submap.set_gates(gates);
  submap.freeze(decode_joint(stored.at("joint")), decode_features(stored.at("features")));
  return submap;
}

json encode(const MotionInput& input) {
  const Overloaded visitor{
      [](std::monostate) { return json::array(); },
      [](const VelocityInput& v) {
        return json{"velocity", v.speed, v.yaw_rate};
      },
      [](const AckermannInput& a) {
        return json{"ackermann", a.speed, a.steering};
      },
      [](const OdometryInput& o) {
        return json{"odometry", o.dx, o.dy, o.dheading};
      },
  };
  return std::visit(visitor, input);
}

MotionInput decode_input(const json& stored) {
  if (stored.empty()) return {};
  const auto value = [&](std::size_t i) { return stored.at(i).get<double>(); };
  const auto kind = stored.at(0).get<std::string>();
  if (kind == "velocity") return VelocityInput{value(1), value(2)};
  if (kind == "ackermann") return AckermannInput{value(1), value(2)};
  if (kind == "odometry") return OdometryInput{value(1), value(2), value(3)};
  refuse(fmt::format("holds an input '{}'", kind));
}

/// What changes with every step.
json present_of(const Snapshot& s) {
  return {{"utime", s.utime},
          {"held_input", encode(s.held_input)},
          {"joint", encode(s.joint)},
          {"error", static_cast<int>(s.error)},
          {"features", encode(s.features)},
          {"next_feature", s.next_feature},
          {"aliases", encode(s.aliases)},
          {"channels", encode(s.channels)},
          {"first_returns", encode(s.first_returns)},
          {"current", s.current},
          {"in_use", s.in_use},
          {"next_gate", s.next_gate}};
}

/// What changes at crossings. @param submaps themselves, or the numbers of their files.
json atlas_of(const Snapshot& s, json submaps) {
  json places = json::array(), links = json::array();
  for (const Pose2& X : s.places) places.push_back(binary(std::array{X.x, X.y, X.heading}));
  for (const auto& [a, b, X_ab] : s.links) links.push_back({a, b, encode(X_ab)});
  return {{"submaps", std::move(submaps)}, {"places", std::move(places)}, {"links", std::move(links)}};
}

/// Gives the file of that number.
using ReadPart = std::function<json(int)>;

Snapshot decode(const json& stored, const ReadPart& read_part) {
  Snapshot s;
  s.utime = whole(stored.at("utime"), limits::kTime);
  s.held_input = decode_input(stored.at("held_input"));
  s.joint = decode_joint(stored.at("joint"));
  s.error = enumerator(stored.at("error"), ErrorKind::invariant);
  s.features = decode_features(stored.at("features"));
  s.next_feature = identity(stored.at("next_feature"));
  for (const json& alias : stored.at("aliases"))
    s.aliases.push_back({identity(alias.at(0)), identity(alias.at(1))});
  s.channels = decode_channels(stored.at("channels"));
  for (const json& first : stored.at("first_returns"))
    s.first_returns.push_back({{first.at(0).get<double>(), first.at(1).get<double>()},
                               identity(first.at(2)),
                               whole(first.at(3), limits::kTime)});
  s.current = identity(stored.at("current"));
  for (const json& feature : stored.at("in_use")) s.in_use.push_back(identity(feature));
  s.next_gate = identity(stored.at("next_gate"));
  const bool is_head = stored.contains("atlas");
  const json atlas = is_head ? read_part(identity(stored.at("atlas"))) : json();
  const json& rest = is_head ? atlas : stored;
  for (const json& submap : rest.at("submaps")) {
    const auto id = static_cast<int>(s.submaps.size());
    s.submaps.push_back(
        std::make_shared<const Submap>(decode_submap(is_head ? read_part(identity(submap)) : submap, id)));
  }
  for (const json& place : rest.at("places")) {
    const std::vector<double> X = numbers(place, 3);
    s.places.push_back({X[0], X[1], X[2]});
  }
  for (const json& link : rest.at("links"))
    s.links.push_back({identity(link.at(0)), identity(link.at(1)), decode_pose(link.at(2))});
  return s;
}

/// A document with the header before it.
std::vector<std::byte> with_header(const json& document) {
  const std::vector<std::uint8_t> cbor = json::to_cbor(document);
  const auto body = std::as_bytes(std::span(cbor));
  std::vector<std::byte> bytes;
  bytes.reserve(kHeaderSize + body.size());
  for (const char c : kMagic) bytes.push_back(static_cast<std::byte>(c));
  append(kMapVersion, bytes);
  append(static_cast<std::uint64_t>(body.size()), bytes);
  append(crc_of(body), bytes);
  bytes.insert(bytes.end(), body.begin(), body.end());
  return bytes;
}

/// The document behind a header that is right.
json checked(std::span<const std::byte> bytes) {
  const auto magic = std::as_bytes(std::span(kMagic));
  if (bytes.size() < magic.size() || std::memcmp(bytes.data(), magic.data(), magic.size()) != 0)
    refuse("is no map: it must begin with the line 'leadline map'");
  if (bytes.size() < kHeaderSize) refuse("is cut off inside its header");
  bytes = bytes.subspan(kMagic.size());
  const auto version = take<std::uint32_t>(bytes);
  if (version != kMapVersion)
    refuse(fmt::format("is of version {}, this program reads version {}{}", version, kMapVersion,
                       version < kMapVersion ? ": older maps do not say what their submaps share" : ""));
  const auto size = take<std::uint64_t>(bytes);
  const auto crc = take<std::uint32_t>(bytes);
  if (bytes.size() != size)
    refuse(fmt::format("has {} bytes after its header, must have {}", bytes.size(), size));
  if (crc_of(bytes) != crc) refuse("is damaged: its checksum is wrong");
  return parse(bytes);
}

/// What @p read makes of a document, @throws std::runtime_error where it does not find what must be there.
template <class Read>
auto understood(Read read) {
  try {
    return read();
  } catch (const json::exception& error) {
    refuse(fmt::format("is not as a map must be: {}", error.what()));
  }
}

/// The document in a file. @throws std::runtime_error naming the file.
json read_document(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file)
    throw std::runtime_error(fmt::format("{}: cannot read: {}", path.string(), std::strerror(errno)));
  const std::vector<char> text{std::istreambuf_iterator<char>(file), {}};
  try {
    return understood([&] { return checked(std::as_bytes(std::span(text))); });
  } catch (const std::runtime_error& error) {
    throw std::runtime_error(fmt::format("{}: {}", path.string(), error.what()));
  }
}

/// What @p read makes of a file's document. @throws std::runtime_error naming the file.
template <class Read>
auto read_file(const std::filesystem::path& path, Read read) {
  const json document = read_document(path);
  try {
    return understood([&] { return read(document); });
  } catch (const std::runtime_error& error) {
    throw std::runtime_error(fmt::format("{}: {}", path.string(), error.what()));
  }
}

}  // namespace

std::vector<std::byte> encode_map(const Snapshot& snapshot) {
  json submaps = json::array();
  for (const auto& submap : snapshot.submaps) submaps.push_back(encode(*submap));
  json map = present_of(snapshot);
  map.update(atlas_of(snapshot, std::move(submaps)));
  return with_header(map);
}

Snapshot decode_map(std::span<const std::byte> bytes) {
  const auto none = [](int) -> json { refuse("is the head of a checkpoint, which lies in several files"); };
  return understood([&] { return decode(checked(bytes), none); });
}

std::vector<std::byte> encode_head(const Snapshot& snapshot, int atlas) {
  json head = present_of(snapshot);
  head["atlas"] = atlas;
  return with_header(head);
}

std::vector<std::byte> encode_atlas(const Snapshot& snapshot, std::span<const int> submaps) {
  return with_header(atlas_of(snapshot, json(std::vector<int>(submaps.begin(), submaps.end()))));
}

std::vector<std::byte> encode_submap(const Submap& submap) { return with_header(encode(submap)); }

std::filesystem::path parts_folder(const std::filesystem::path& head) {
  return head.parent_path() / "checkpoint.parts";
}

std::filesystem::path part_path(const std::filesystem::path& head, int number) {
  return parts_folder(head) / fmt::format("{}.map", number);
}

void write_map(const std::filesystem::path& path, const Snapshot& snapshot) {
  AtomicFile file(path);
  file.write(encode_map(snapshot));
  file.commit();
}

bool is_map_file(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file)
    throw std::runtime_error(fmt::format("{}: cannot read: {}", path.string(), std::strerror(errno)));
  std::string begin(kMagic.size(), '\0');
  file.read(begin.data(), static_cast<std::streamsize>(begin.size()));
  return file && begin == kMagic;
}

Snapshot read_map(const std::filesystem::path& path) {
  const auto read_part = [&](int number) { return read_document(part_path(path, number)); };
  return read_file(path, [&](const json& document) { return decode(document, read_part); });
}

std::optional<Parts> read_parts(const std::filesystem::path& head) {
  return read_file(head, [&](const json& document) -> std::optional<Parts> {
    if (!document.contains("atlas")) return std::nullopt;
    Parts parts{identity(document.at("atlas")), {}};
    const json atlas = read_document(part_path(head, parts.atlas));
    for (const json& submap : atlas.at("submaps")) parts.submaps.push_back(identity(submap));
    return parts;
  });
}

}  // namespace leadline::app
