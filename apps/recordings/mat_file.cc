#include "apps/recordings/mat_file.h"

#include <fmt/format.h>

#include <bit>
#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <span>
#include <stdexcept>
#include <string_view>
#include <system_error>
#include <vector>

namespace leadline::app {
namespace {

static_assert(std::endian::native == std::endian::little, "the structure of the file is read as it is");

/// Refuses what makes matio allocate without bound, for it believes the sizes and dimensions that it reads.
/// A file is a header and a sequence of elements: type (4 bytes), size (4), content. An element that is not
/// compressed is a matrix, made of elements in its turn: flags with its class, dimensions, name, values. What
/// is compressed has a checksum against accidents.
class Structure {
 public:
  Structure(const std::string& path, std::span<const char> bytes) : path_(path), bytes_(bytes) {}

  void check() const {
    constexpr std::size_t kHeaderSize = 128;
    constexpr std::string_view kVersion("\x00\x01IM", 4);
    if (bytes_.size() < kHeaderSize || std::string_view(bytes_.data(), kHeaderSize).substr(124) != kVersion) {
      throw std::runtime_error(path_ + ": must be a MATLAB file of version 5 to 7, little-endian");
    }
    for (std::size_t at = kHeaderSize; at < bytes_.size();) {
      const std::uint32_t type = word(at), size = word(at + 4);
      if (size > bytes_.size() - at - 8) fail(at, "the file ends inside a variable");
      if (type == MAT_T_MATRIX) {
        check_matrix(at + 8, at + 8 + size);
      } else if (type != MAT_T_COMPRESSED) {
        fail(at, "no variable begins here");
      }
      at += 8 + std::size_t{size};
    }
  }

 private:
  void check_matrix(std::size_t begin, std::size_t end) const {
    const std::uint32_t matrix_class = word(begin + 8) & 0xff;
    const bool numbers = matrix_class >= MAT_C_DOUBLE && matrix_class <= MAT_C_UINT64;
    const bool has_flags = word(begin) == MAT_T_UINT32 && word(begin + 4) == 8;
    const bool has_two_dimensions = word(begin + 16) == MAT_T_INT32 && word(begin + 20) == 8;
    if (!has_flags || !has_two_dimensions || !numbers) fail(begin, "a variable is not a matrix of numbers");

    const std::uint32_t rows = word(begin + 24), cols = word(begin + 28);
    if (rows > end - begin || cols > end - begin || std::uint64_t{rows} * cols > end - begin) {
      fail(begin, "a variable is shorter than its dimensions");
    }
    for (std::size_t at = begin; at < end;) {
      const std::uint32_t type = word(at);
      const bool small = type > 0xffff;  // its size is in the upper half, its content in the second word
      const std::size_t size = small ? 8 : 8 + (std::size_t{word(at + 4)} + 7) / 8 * 8;
      if (size > end - at) fail(at, "a variable is shorter than its parts");
      at += size;
    }
  }

  std::uint32_t word(std::size_t at) const {
    std::uint32_t word = 0;
    if (bytes_.size() - at < sizeof word) fail(at, "the file ends inside a variable");
    std::memcpy(&word, &bytes_[at], sizeof word);
    return word;
  }

  [[noreturn]] void fail(std::size_t at, std::string_view why) const {
    throw std::runtime_error(fmt::format("{}: byte {}: {}", path_, at, why));
  }

  const std::string& path_;
  std::span<const char> bytes_;
};

std::string size_text(Eigen::Index size) { return size == MatFile::kAny ? "any" : std::to_string(size); }

bool matches(Eigen::Index size, Eigen::Index wanted) { return wanted == MatFile::kAny || size == wanted; }

}  // namespace

MatFile::MatFile(const std::filesystem::path& path) : path_(path.string()), file_(nullptr, Mat_Close) {
  std::error_code error;
  const std::uintmax_t size = std::filesystem::file_size(path, error);
  if (error) throw std::runtime_error(fmt::format("{}: cannot read: {}", path_, error.message()));
  std::vector<char> bytes(size);
  std::ifstream file(path, std::ios::binary);
  if (!file.read(bytes.data(), static_cast<std::streamsize>(size))) {
    throw std::runtime_error(fmt::format("{}: cannot read: {}", path_, std::strerror(errno)));
  }
  Structure(path_, bytes).check();
  file_.reset(Mat_Open(path_.c_str(), MAT_ACC_RDONLY));
  if (!file_) throw std::runtime_error(path_ + ": is not a sound MATLAB file");
}

Eigen::MatrixXd MatFile::matrix(const std::string& name, Eigen::Index rows, Eigen::Index cols,
                                Limits limits) const {
  const std::unique_ptr<matvar_t, void (*)(matvar_t*)> variable(Mat_VarRead(file_.get(), name.c_str()),
                                                                Mat_VarFree);
  if (!variable) fail(name, "is missing or damaged");
  const bool doubles = variable->class_type == MAT_C_DOUBLE && variable->data_type == MAT_T_DOUBLE;
  if (!doubles || variable->isComplex != 0 || variable->rank != 2)
    fail(name, "must be a matrix of real doubles");

  const auto found_rows = static_cast<Eigen::Index>(variable->dims[0]);
  const auto found_cols = static_cast<Eigen::Index>(variable->dims[1]);
  const bool complete =
      variable->data && variable->nbytes == sizeof(double) * variable->dims[0] * variable->dims[1];
  if (!complete || !matches(found_rows, rows) || !matches(found_cols, cols)) {
    fail(name, "is {} x {}, must be {} x {}", found_rows, found_cols, size_text(rows), size_text(cols));
  }
  const Eigen::Map<const Eigen::MatrixXd> values(static_cast<const double*>(variable->data), found_rows,
                                                 found_cols);
  for (Eigen::Index col = 0; col < found_cols; ++col) {
    for (Eigen::Index row = 0; row < found_rows; ++row) {
      if (limits.contain(values(row, col))) continue;
      fail(name, "has {} in row {}, column {}, must be from {} to {}", values(row, col), row + 1, col + 1,
           limits.min, limits.max);
    }
  }
  return values;
}

Eigen::VectorXd MatFile::vector(const std::string& name, Eigen::Index size, Limits limits) const {
  const Eigen::MatrixXd stored = matrix(name, kAny, kAny, limits);
  if ((stored.rows() != 1 && stored.cols() != 1) || !matches(stored.size(), size)) {
    fail(name, "is {} x {}, must be a vector of {} elements", stored.rows(), stored.cols(), size_text(size));
  }
  return stored.reshaped();
}

template <class... Args>
void MatFile::fail(const std::string& name, const char* format, const Args&... args) const {
  throw std::runtime_error(
      fmt::format("{}: variable {} {}", path_, name, fmt::format(fmt::runtime(format), args...)));
}

}  // namespace leadline::app
