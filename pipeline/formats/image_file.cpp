#include "pipeline/formats/image_file.h"

#include <algorithm>
#include <array>

#include "pipeline/formats/metaimage.h"
#include "pipeline/formats/nifti.h"
#include "pipeline/formats/nrrd.h"
#include "runtime/base/error.h"

namespace beatlas::formats {
namespace {

namespace fs = std::filesystem;

std::string lower_name(const fs::path& file) {
  std::string name = file.filename().string();
  std::transform(name.begin(), name.end(), name.begin(), [](unsigned char c) {
    return static_cast<char>(c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c);
  });
  return name;
}

template <std::size_t N>
bool ends_with_any(const std::string& name, const std::array<std::string_view, N>& ends) {
  return std::any_of(ends.begin(), ends.end(),
                     [&](std::string_view end) { return name.ends_with(end); });
}

ImageFormat demand_format(const fs::path& file) {
  const auto format = format_of(file);
  if (!format) throw_invalid(file.string() + ": the end of its name is that of no image file");
  return *format;
}

constexpr std::array<std::string_view, 6> kNifti{".nii",    ".nii.gz", ".hdr",
                                                 ".hdr.gz", ".img",    ".img.gz"};
constexpr std::array<std::string_view, 2> kNrrd{".nrrd", ".nhdr"};
constexpr std::array<std::string_view, 2> kMetaImage{".mha", ".mhd"};
constexpr std::array<std::string_view, 9> kVoxels{
    ".img", ".img.gz", ".img.bz2", ".raw", ".raw.gz", ".raw.bz2", ".zraw", ".zraw.gz", ".zraw.bz2"};

}  // namespace

std::string_view format_name(ImageFormat format) noexcept {
  switch (format) {
    case ImageFormat::Nifti:
      return "nifti";
    case ImageFormat::Nrrd:
      return "nrrd";
    case ImageFormat::MetaImage:
      return "metaimage";
  }
  return "";
}

std::optional<ImageFormat> format_of(const fs::path& file) {
  const std::string name = lower_name(file);
  if (ends_with_any(name, kNifti)) return ImageFormat::Nifti;
  if (ends_with_any(name, kNrrd)) return ImageFormat::Nrrd;
  if (ends_with_any(name, kMetaImage)) return ImageFormat::MetaImage;
  return std::nullopt;
}

bool may_be_voxels_of_another(const fs::path& file) {
  return ends_with_any(lower_name(file), kVoxels);
}

std::vector<fs::path> files_of_image(const fs::path& file) {
  const ImageFormat format = demand_format(file);
  try {
    if (format == ImageFormat::Nifti) return files_of_nifti(file);
    std::vector<fs::path> out =
        format == ImageFormat::Nrrd ? data_files_of_nrrd(file) : data_files_of_metaimage(file);
    out.insert(out.begin(), file);
    return out;
  } catch (const Error& error) {
    throw error.with_context(file.string());
  }
}

ImageFile read_image_file(const fs::path& file) {
  ImageFile out;
  switch (demand_format(file)) {
    case ImageFormat::Nifti:
      out.images = read_nifti(file, &out.header);
      break;
    case ImageFormat::Nrrd:
      out = read_nrrd(file);
      break;
    case ImageFormat::MetaImage:
      out = read_metaimage(file);
      break;
  }
  return out;
}

}  // namespace beatlas::formats
