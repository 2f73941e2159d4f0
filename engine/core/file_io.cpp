// SPDX-License-Identifier: MIT
#include "engine/core/file_io.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <utility>
#include <vector>

#include "engine/core/error.h"
#include "engine/core/task.h"

namespace airclay {
namespace {

constexpr size_t kWrittenAtOnce = size_t(4) << 20;  // bytes; between blocks the task can be cancelled

/// An open file descriptor, closed by the destructor.
class FileHandle {
 public:
  explicit FileHandle(int descriptor) : descriptor_(descriptor) {}
  FileHandle(const FileHandle&) = delete;
  FileHandle& operator=(const FileHandle&) = delete;
  ~FileHandle() {
    if (descriptor_ >= 0) ::close(descriptor_);
  }
  int get() const { return descriptor_; }
  /// close() also reports late write errors (quotas, network folders).
  bool close() { return ::close(std::exchange(descriptor_, -1)) == 0; }

 private:
  int descriptor_;
};

std::string reason() {
  return std::strerror(errno);
}

void writeAll(FileHandle& handle, const std::string& content, const std::string& name) {
  for (size_t written = 0; written < content.size();) {
    reportProgress(double(written) / double(content.size()));
    const size_t most = std::min(content.size() - written, kWrittenAtOnce);
    const ssize_t count = ::write(handle.get(), content.data() + written, most);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) throw Error(name + ": cannot be written: " + reason());
    written += size_t(count);
  }
  if (!handle.close()) throw Error(name + ": cannot be written: " + reason());
}

/// Writes into a device or a pipe directly: renaming a temporary file would replace it.
void writeDirectly(const std::filesystem::path& file, const std::string& content) {
  FileHandle handle(::open(file.c_str(), O_WRONLY | O_CLOEXEC));
  if (handle.get() < 0) throw Error(file.string() + ": cannot be written: " + reason());
  writeAll(handle, content, file.string());
}

}  // namespace

std::optional<double> parseNumber(std::string_view text) {
  if (text.starts_with('+')) text.remove_prefix(1);
  double number = 0;
  const auto [end, status] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (text.empty() || end != text.data() + text.size() || status != std::errc() || !std::isfinite(number))
    return std::nullopt;
  return number;
}

std::string exactNumber(double value) {
  char digits[32];
  return std::string(digits, std::to_chars(digits, digits + sizeof digits, value).ptr);
}

std::string printable(std::string_view word) {
  std::string text;
  for (const char c : word.substr(0, 40)) text += c >= ' ' && c <= '~' ? c : '?';
  return word.size() > 40 ? text + "..." : text;
}

std::string lowerCaseExtension(const std::filesystem::path& file) {
  std::string extension = file.extension().string();
  for (char& c : extension)
    if (c >= 'A' && c <= 'Z') c = char(c - 'A' + 'a');
  return extension;
}

std::string readWhole(const std::filesystem::path& file, size_t max_bytes) {
  const std::string name = file.string();
  FileHandle handle(::open(file.c_str(), O_RDONLY | O_CLOEXEC));
  if (handle.get() < 0) throw Error(name + ": cannot be read: " + reason());
  std::string content;
  std::vector<char> block(size_t(1) << 20);
  while (true) {
    const ssize_t count = ::read(handle.get(), block.data(), block.size());
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) throw Error(name + ": cannot be read: " + reason());
    if (count == 0) return content;
    if (content.size() + size_t(count) > max_bytes)
      throw Error(name + ": is larger than " + std::to_string(max_bytes >> 20) +
                  " MB, the largest size that is read");
    content.append(block.data(), size_t(count));
  }
}

void writeWhole(const std::filesystem::path& file, const std::string& content) {
  std::error_code ignored;
  if (std::filesystem::is_directory(file, ignored))
    throw Error(file.string() + ": cannot be written: it is a folder; name a file");
  if (std::filesystem::exists(file, ignored) && !std::filesystem::is_regular_file(file, ignored))
    return writeDirectly(file, content);
  // A symbolic link stays; its target is replaced.
  const std::filesystem::path target =
      std::filesystem::is_symlink(file, ignored) ? std::filesystem::weakly_canonical(file, ignored) : file;
  std::filesystem::path part = target;
  part += ".part-" + std::to_string(::getpid());
  FileHandle handle(::open(part.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666));
  if (handle.get() < 0)
    throw Error(file.string() + ": cannot be written: " + reason() + "; name a file in a writable folder");
  try {
    writeAll(handle, content, file.string());
    if (::rename(part.c_str(), target.c_str()) != 0)
      throw Error(file.string() + ": cannot be written: " + reason());
  } catch (...) {  // on cancellation too
    ::unlink(part.c_str());
    throw;
  }
}

}  // namespace airclay
