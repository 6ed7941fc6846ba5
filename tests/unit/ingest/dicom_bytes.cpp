#include "tests/unit/ingest/dicom_bytes.h"

#include <algorithm>
#include <cstdint>

#include "tests/unit/formats/image_bytes.h"

namespace beatlas::test {
namespace {

class Elements {
 public:
  Elements(bool implicit, bool big_endian) : implicit_(implicit), big_endian_(big_endian) {}

  void number(std::uint64_t value, std::size_t bytes) {
    for (std::size_t n = 0; n < bytes; ++n) {
      const std::size_t byte = big_endian_ ? bytes - 1 - n : n;
      bytes_ += static_cast<char>(value >> (8 * byte) & 0xFF);
    }
  }
  void head(int group, int element, const std::string& kind, std::uint64_t length) {
    number(static_cast<std::uint64_t>(group), 2);
    number(static_cast<std::uint64_t>(element), 2);
    if (implicit_) return number(length, 4);
    bytes_ += kind;
    if (kind != "OB" && kind != "OW" && kind != "SQ") return number(length, 2);
    number(0, 2);
    number(length, 4);
  }
  void text(int group, int element, const std::string& kind, std::string value) {
    if (value.size() % 2 != 0) value += kind == "UI" ? '\0' : ' ';
    head(group, element, kind, value.size());
    bytes_ += value;
  }
  void whole(int group, int element, int value) {
    head(group, element, "US", 2);
    number(static_cast<std::uint64_t>(value), 2);
  }
  void raw(const std::string& bytes) { bytes_ += bytes; }
  [[nodiscard]] const std::string& bytes() const { return bytes_; }

 private:
  bool implicit_;
  bool big_endian_;
  std::string bytes_;
};

}  // namespace

std::string data_set(const DicomForm& form) {
  constexpr std::uint64_t kUntold = 0xFFFFFFFF;
  Elements out(form.syntax == kImplicit, form.syntax == kBigEndian);
  const std::string number = std::to_string(form.instance);
  const bool several = form.frames != 1;
  out.text(8, 0x8, "CS", "ORIGINAL\\PRIMARY\\M");
  out.text(8, 0x16, "UI", "1.2.840.10008.5.1.4.1.1.4");
  out.text(8, 0x18, "UI", "1.2.3." + number);
  out.text(8, 0x60, "CS", "MR");
  out.text(0x10, 0x10, "PN", "SECRET^NAME");
  out.text(0x10, 0x20, "LO", "SECRETID");
  out.text(0x18, 0x1060, "DS", std::to_string(form.trigger_ms));
  out.text(0x18, 0x1062, "IS", "900");
  out.text(0x20, 0xD, "UI", "1.2.4");
  out.text(0x20, 0xE, "UI", "1.2.5");
  out.text(0x20, 0x11, "IS", "1");
  out.text(0x20, 0x13, "IS", number);
  out.text(0x20, 0x32, "DS", "0\\0\\" + std::to_string(form.slice_mm));
  out.text(0x20, 0x37, "DS", "1\\0\\0\\0\\1\\0");
  out.whole(0x28, 2, 1);
  out.text(0x28, 4, "CS", "MONOCHROME2");
  if (several) out.text(0x28, 8, "IS", std::to_string(form.frames));
  out.whole(0x28, 0x10, form.rows);
  out.whole(0x28, 0x11, form.columns);
  out.text(0x28, 0x30, "DS", "2\\2");
  out.whole(0x28, 0x100, form.bits);
  out.whole(0x28, 0x101, form.bits);
  out.whole(0x28, 0x102, form.bits - 1);
  out.whole(0x28, 0x103, 0);
  if (form.fragments.empty()) {
    out.head(0x7FE0, 0x10, "OW", form.pixels.size());
    out.raw(form.pixels);
  } else {
    out.head(0x7FE0, 0x10, "OB", kUntold);
    const auto item = [&](int kind, const std::string& value) {
      out.number(0xFFFE, 2);
      out.number(static_cast<std::uint64_t>(kind), 2);
      out.number(value.size(), 4);
      out.raw(value);
    };
    item(0xE000, "");  // no table of offsets
    for (const std::string& fragment : form.fragments) item(0xE000, fragment);
    item(0xE0DD, "");
  }
  out.raw(form.behind);
  return out.bytes();
}

std::string with_head(const std::string& syntax, std::string data_set, int instance) {
  Elements meta(false, false);
  meta.text(2, 2, "UI", "1.2.840.10008.5.1.4.1.1.4");
  meta.text(2, 3, "UI", "1.2.3." + std::to_string(instance));
  meta.text(2, 0x10, "UI", syntax);
  Elements length(false, false);
  length.head(2, 0, "UL", 4);
  length.number(meta.bytes().size(), 4);
  if (syntax == kDeflated) {
    const std::string stream = zlib(data_set);  // without its head of 2 and check sum of 4 bytes
    data_set = stream.substr(2, stream.size() - 6);
    if (data_set.size() % 2 != 0) data_set += '\0';
  }
  std::string out(128, '\0');
  out.append("DICM").append(length.bytes()).append(meta.bytes()).append(data_set);
  return out;
}

std::string dicom_file(const DicomForm& form) {
  return with_head(form.syntax, data_set(form), form.instance);
}

std::string run_lengths(const std::string& bytes) {
  constexpr std::size_t kMostLiteral = 128;
  std::string out(64, '\0');
  put(out, 0, std::uint32_t{1});
  put(out, 4, std::uint32_t{64});
  for (std::size_t at = 0; at < bytes.size(); at += kMostLiteral) {
    const std::string part = bytes.substr(at, kMostLiteral);
    out += static_cast<char>(part.size() - 1);
    out += part;
  }
  if (out.size() % 2 != 0) out += '\0';
  return out;
}

}  // namespace beatlas::test
