/// Import of a folder of single-frame DICOM files against vtk-dicom's own directory and reader.
///
///     ingest_bench [RUNS [SLICES [PHASES [PIXELS]]]]     5 runs of 64 x 15 files of 256 x 256
///     pixels
///
/// Both read the same folder, in turns, after one reading of each that does not count. The
/// machine's speed moves between runs, so the ratio of the medians is what counts.

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include <sys/resource.h>
#include <unistd.h>
#include <vtkDICOMDirectory.h>
#include <vtkDICOMReader.h>
#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkSmartPointer.h>
#include <vtkStringArray.h>

#include "pipeline/formats/dicom_writer.h"
#include "pipeline/ingest/ingest.h"

namespace {

using namespace beatlas;
namespace fs = std::filesystem;

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

double seconds(const auto& work) {
  const auto start = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

Cine made_cine(int slices, int phases, int pixels) {
  Cine out;
  out.rr_interval_s = 0.9;
  out.images.grid.size = {pixels, pixels, slices};
  out.images.grid.mm_from_index.linear().diagonal() = Vec3(1, 1, 3);
  const std::size_t count = out.images.grid.count();
  for (int p = 0; p < phases; ++p) {
    auto& phase = out.images.phases.emplace_back(count);
    unsigned state = 12345U + static_cast<unsigned>(p);
    for (float& value : phase) {
      state = state * 1664525U + 1013904223U;
      value = static_cast<float>(state >> 20);
    }
  }
  return out;
}

/// Reads all series as vtk-dicom does; the number of values read.
std::size_t read_with_vtk(const fs::path& folder) {
  vtkNew<vtkDICOMDirectory> directory;
  directory->SetDirectoryName(folder.c_str());
  directory->SetScanDepth(3);
  directory->Update();
  std::vector<vtkSmartPointer<vtkImageData>> kept;  // an importer, too, keeps what it read
  std::size_t values = 0;
  for (int series = 0; series < directory->GetNumberOfSeries(); ++series) {
    vtkNew<vtkDICOMReader> reader;
    reader->SetFileNames(directory->GetFileNamesForSeries(series));
    reader->Update();
    vtkSmartPointer<vtkImageData> image = reader->GetOutput();
    values += static_cast<std::size_t>(image->GetNumberOfPoints()) *
              static_cast<std::size_t>(image->GetNumberOfScalarComponents());
    kept.push_back(image);
  }
  return values;
}

std::size_t read_with_ours(const fs::path& folder) {
  StageContext context;
  const Exam exam = ingest::read_exam({folder}, {}, context);
  return exam.stack.grid().count() * exam.stack.images.phases.size();
}

long peak_kb() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return usage.ru_maxrss;
}

}  // namespace

int main(int argc, char** argv) {
  const auto argument = [&](int i, int otherwise) {
    return argc > i ? std::atoi(argv[i]) : otherwise;
  };
  const int runs = std::max(1, argument(1, 5));
  const int slices = argument(2, 64);
  const int phases = argument(3, 15);
  const int pixels = argument(4, 256);
  std::string name = (fs::temp_directory_path() / "beatlas_bench_XXXXXX").string();
  if (!mkdtemp(name.data())) return 5;
  const fs::path folder = name;
  const fs::path one = folder / "one_series";
  const fs::path each = folder / "series_per_slice";
  {
    const Cine cine = made_cine(slices, phases, pixels);
    formats::write_dicom(one, cine, {.series_per_slice = false});
    formats::write_dicom(each, cine, {.series_per_slice = true});
  }
  const auto values = static_cast<std::size_t>(slices) * static_cast<std::size_t>(phases) *
                      static_cast<std::size_t>(pixels) * static_cast<std::size_t>(pixels);
  std::printf("%d files of %d x %d pixels, %d runs in turns, medians\n", slices * phases, pixels,
              pixels, runs);
  bool good = true;
  for (const fs::path& source : {one, each}) {
    std::vector<double> ours;
    std::vector<double> theirs;
    for (int run = -1; run < runs; ++run) {
      const double a = seconds([&] { good = good && read_with_ours(source) == values; });
      const double b = seconds([&] { good = good && read_with_vtk(source) == values; });
      if (run < 0) continue;
      ours.push_back(a);
      theirs.push_back(b);
    }
    std::printf("%-18s ours %.3f s, vtk-dicom %.3f s, ratio %.2f\n", source.filename().c_str(),
                median(ours), median(theirs), median(ours) / median(theirs));
  }
  std::printf("peak memory of the process %.0f MB\n", static_cast<double>(peak_kb()) / 1024);
  std::error_code ignored;
  fs::remove_all(folder, ignored);
  if (!good) std::printf("a reader did not read all values\n");
  return good ? 0 : 1;
}
