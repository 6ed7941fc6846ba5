#include "pipeline/ingest/dicom_scan.h"

#include <algorithm>
#include <array>
#include <tuple>
#include <unordered_map>

#include <vtkDICOMMetaData.h>
#include <vtkNew.h>

#include "pipeline/core/parallel.h"
#include "pipeline/ingest/dicom_file.h"
#include "pipeline/ingest/dicom_pixels.h"
#include "runtime/base/error.h"

namespace beatlas::ingest {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kBlock = 64;  // files between two looks at `cancel`

using Content = std::tuple<int, std::optional<double>, int, const std::string&, const std::string&,
                           const std::string&, std::optional<double>, std::optional<double>,
                           std::optional<double>, std::array<double, 9>, std::array<double, 4>,
                           std::array<int, 3>, const std::string&, std::optional<double>>;

/// All that an image says of itself but where it lies.
Content content(const DicomImage& image) {
  const auto& p = image.position_lps;
  const auto& r = image.row_lps;
  const auto& c = image.column_lps;
  const FrameStamp& stamp = image.stamp;
  return {image.series_number,
          stamp.instance,
          image.frame,
          image.series_uid,
          image.study_uid,
          image.patient,
          stamp.trigger_ms,
          stamp.temporal_position,
          stamp.acquisition_s,
          {p[0], p[1], p[2], r[0], r[1], r[2], c[0], c[1], c[2]},
          {image.row_step_mm, image.column_step_mm, image.contrast.echo_ms,
           image.contrast.inversion_ms},
          {image.rows, image.columns, image.magnitude ? 1 : 0},
          image.kind,
          stamp.acquisition_number};
}

auto key(const FileHeader& header) {
  return std::tie(header.series_number, header.instance, header.instance_uid);
}

bool same_content(const FileHeader& a, const FileHeader& b) {
  return std::equal(
      a.images.begin(), a.images.end(), b.images.begin(), b.images.end(),
      [](const DicomImage& x, const DicomImage& y) { return content(x) == content(y); });
}

std::vector<FileHeader> read_headers(const std::vector<fs::path>& files, IdentityWords& words,
                                     StageContext& context) {
  const vtkNew<vtkDICOMMetaData> first;  // what VTK sets up once, it sets up here, in one thread
  std::vector<FileHeader> out(files.size());
  std::vector<IdentityWords> met(std::min(kBlock, files.size()));
  for (std::size_t begin = 0; begin < files.size(); begin += kBlock) {
    context.check_cancelled();
    const std::size_t count = std::min(kBlock, files.size() - begin);
    parallel_for(count,
                 [&](std::size_t i) { out[begin + i] = read_header(files[begin + i], met[i]); });
    context.progress(0.4 * static_cast<double>(begin + count) / static_cast<double>(files.size()));
  }
  for (const IdentityWords& some : met) words.merge(some);
  return out;
}

/// Throws if there is a file that cannot be what it seems: the first by series and instance.
void refuse_broken(const std::vector<fs::path>& files, const std::vector<FileHeader>& headers,
                   const std::vector<fs::path>& sources, bool named, const IdentityWords& words) {
  using Kind = FileHeader::Kind;
  std::vector<std::size_t> bad;
  for (std::size_t i = 0; i < headers.size(); ++i) {
    const Kind kind = headers[i].kind;
    if (kind == Kind::Damaged || kind == Kind::Wrong ||
        (named && (kind == Kind::NotDicom || kind == Kind::Empty))) {
      bad.push_back(i);
    }
  }
  if (bad.empty()) return;
  std::sort(bad.begin(), bad.end(), [&](std::size_t a, std::size_t b) {
    const auto ka = key(headers[a]);
    const auto kb = key(headers[b]);
    return ka != kb ? ka < kb : files[a] < files[b];
  });
  const FileHeader& first = headers[bad.front()];
  const auto alike =
      static_cast<std::size_t>(std::count_if(bad.begin(), bad.end(), [&](std::size_t i) {
        return headers[i].kind == first.kind && headers[i].problem == first.problem;
      }));
  std::string sentence = shown_to(sources, files[bad.front()], words) + ": ";
  if (first.kind == Kind::Empty) {
    sentence += "the file is empty; copy it again";
  } else if (first.kind == Kind::NotDicom) {
    sentence += "it is no image that can be read";
  } else if (first.kind == Kind::Damaged) {
    sentence += "the file is truncated or damaged; copy it again or take it out of the folder";
  } else {
    sentence += first.problem + "; export the original images or take it out of the folder";
  }
  if (alike > 1) sentence += " (" + std::to_string(alike - 1) + " more are like it)";
  if (alike < bad.size()) {
    sentence += " (" + std::to_string(bad.size() - alike) + " more have other faults)";
  }
  throw_invalid(sentence);
}

/// Throws unless two files that say the same of themselves show the same.
void check_pixels(const FileHeader& one, const FileHeader& other, DicomPixels& pixels,
                  const std::vector<fs::path>& sources, const IdentityWords& words) {
  const auto shown = [&](const FileHeader& header) {
    std::vector<std::string> out;
    for (const DicomImage& image : header.images) out.push_back(pixels.fingerprint(image));
    return out;
  };
  if (shown(one) == shown(other)) return;
  throw_invalid(shown_to(sources, one.images.front().file, words) + " and " +
                shown_to(sources, other.images.front().file, words) +
                ": they are one image by their headers but differ in their pixels; take the wrong "
                "one out of the folder");
}

/// Files in the order of what they say of themselves; names decide only between copies.
std::vector<std::size_t> order_by_content(const std::vector<fs::path>& files,
                                          const std::vector<FileHeader>& headers) {
  std::vector<std::size_t> order(files.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    const auto ka = key(headers[a]);
    const auto kb = key(headers[b]);
    if (ka != kb) return ka < kb;
    // Same UID: by content; the name decides only which of two copies is opened.
    const auto less = [](const DicomImage& x, const DicomImage& y) {
      return content(x) < content(y);
    };
    const auto& ia = headers[a].images;
    const auto& ib = headers[b].images;
    if (std::lexicographical_compare(ia.begin(), ia.end(), ib.begin(), ib.end(), less)) return true;
    if (std::lexicographical_compare(ib.begin(), ib.end(), ia.begin(), ia.end(), less)) {
      return false;
    }
    return files[a] < files[b];
  });
  return order;
}

std::vector<fs::path> empty_files(const std::vector<fs::path>& files,
                                  const std::vector<FileHeader>& headers) {
  std::vector<fs::path> out;
  for (std::size_t i = 0; i < files.size(); ++i) {
    if (headers[i].kind == FileHeader::Kind::Empty) out.push_back(files[i]);
  }
  std::sort(out.begin(), out.end());
  return out;
}

void count(const FileHeader& header, DicomScan& scan) {
  using Kind = FileHeader::Kind;
  scan.not_dicom += header.kind == Kind::NotDicom ? 1 : 0;
  scan.not_image += header.kind == Kind::NotImage ? 1 : 0;
  scan.not_standard += header.kind == Kind::Private ? 1 : 0;
  scan.not_grey += header.kind == Kind::NotGrey ? 1 : 0;
  if (header.kind != Kind::Image) return;
  scan.without_place += header.without_place;
  scan.straightened += header.straightened;
}

}  // namespace

DicomScan scan_dicom(const std::vector<fs::path>& sources, const std::vector<fs::path>& files,
                     bool named, StageContext& context) {
  DicomScan out;
  out.files = static_cast<int>(files.size());
  std::vector<FileHeader> headers = read_headers(files, out.words, context);
  refuse_broken(files, headers, sources, named, out.words);

  out.empty = empty_files(files, headers);
  DicomPixels pixels;
  std::unordered_map<std::string, std::vector<std::size_t>> met;  // by instance UID
  std::vector<std::size_t> kept;
  for (const std::size_t i : order_by_content(files, headers)) {
    FileHeader& header = headers[i];
    count(header, out);
    if (header.images.empty()) continue;
    if (!header.instance_uid.empty()) {
      auto& others = met[header.instance_uid];
      const auto copy = std::find_if(others.begin(), others.end(), [&](std::size_t other) {
        return same_content(headers[other], header);
      });
      if (copy != others.end()) {
        check_pixels(headers[*copy], header, pixels, sources, out.words);
        ++out.copies;
        continue;
      }
      if (!others.empty()) ++out.shared_uids;
      others.push_back(i);
    }
    kept.push_back(i);
    const auto images = static_cast<int>(header.images.size());
    if (header.modality != "MR") {
      out.other_modalities[is_modality_code(header.modality) ? header.modality : ""] += images;
    }
    if (header.images.front().layout.inverted) out.inverted += images;
  }
  for (const std::size_t i : kept) {
    std::move(headers[i].images.begin(), headers[i].images.end(), std::back_inserter(out.images));
  }
  std::stable_sort(
      out.images.begin(), out.images.end(),
      [](const DicomImage& a, const DicomImage& b) { return content(a) < content(b); });
  return out;
}

}  // namespace beatlas::ingest
