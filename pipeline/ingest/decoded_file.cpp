#include "pipeline/ingest/decoded_file.h"

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <iterator>
#include <string>
#include <string_view>

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>
#include <vtkDICOMReader.h>
#include <vtkExecutive.h>
#include <vtkImageData.h>
#include <vtkIntArray.h>
#include <vtkNew.h>
#include <vtkType.h>

#include "pipeline/ingest/gdcm_silence.h"
#include "pipeline/ingest/packed_frames.h"
#include "pipeline/ingest/vtk_silence.h"

namespace beatlas::ingest {
namespace {

constexpr rlim_t kMostSeconds = 120;     // of computing, for one file
constexpr unsigned kMostWaiting = 1200;  // [s]
constexpr std::size_t kWidest = 8;       // bytes of a stored number

/// What lies at the start of the shared memory; behind it the slice of each frame, then the pixels.
struct Head {
  int type;  ///< of VTK
};

std::size_t pixels_at(std::size_t frames) {
  const std::size_t end = sizeof(Head) + frames * sizeof(int);
  return (end + kWidest - 1) / kWidest * kWidest;
}

/// Whether `work` said yes, in a copy of this process that may end as it likes.
template <class Work>
bool done_apart(const Work& work) {
  const pid_t parent = ::getpid();
  const pid_t child = ::fork();
  if (child < 0) return false;
  if (child == 0) {
    // Nobody is left to do the work for, or to hear of it.
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (::getppid() != parent) ::_exit(1);
    const int nowhere = ::open("/dev/null", O_RDWR | O_CLOEXEC);
    for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) ::dup2(nowhere, stream);
    for (const int end : {SIGABRT, SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGALRM, SIGXCPU}) {
      ::signal(end, SIG_DFL);
    }
    const rlimit none{.rlim_cur = 0, .rlim_max = 0};
    ::setrlimit(RLIMIT_CORE, &none);
    const rlimit computing{.rlim_cur = kMostSeconds, .rlim_max = kMostSeconds};
    ::setrlimit(RLIMIT_CPU, &computing);
    ::alarm(kMostWaiting);
    bool done = false;
    try {
      done = work();
    } catch (...) {
    }
    ::_exit(done ? 0 : 1);
  }
  int status = 0;
  pid_t ended = 0;
  do {
    ended = ::waitpid(child, &status, 0);
  } while (ended < 0 && errno == EINTR);
  return ended == child && WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

template <class Stored>
void as_float(const void* data, std::size_t first, std::span<float> out) {
  const auto* begin = static_cast<const Stored*>(data) + first;
  std::transform(begin, begin + out.size(), out.begin(),
                 [](Stored value) { return static_cast<float>(value); });
}

bool as_float(int type, const void* data, std::size_t first, std::span<float> out) {
  switch (type) {
    case VTK_UNSIGNED_CHAR:
      as_float<unsigned char>(data, first, out);
      return true;
    case VTK_SIGNED_CHAR:
    case VTK_CHAR:
      as_float<signed char>(data, first, out);
      return true;
    case VTK_UNSIGNED_SHORT:
      as_float<unsigned short>(data, first, out);
      return true;
    case VTK_SHORT:
      as_float<short>(data, first, out);
      return true;
    case VTK_UNSIGNED_INT:
      as_float<unsigned int>(data, first, out);
      return true;
    case VTK_INT:
      as_float<int>(data, first, out);
      return true;
    case VTK_FLOAT:
      as_float<float>(data, first, out);
      return true;
    case VTK_DOUBLE:
      as_float<double>(data, first, out);
      return true;
    default:
      return false;
  }
}

/// Decodes a whole file into shared memory of `bytes`; false if that fails.
bool decode(const std::string& file, const DicomImage& image, void* shared, std::size_t bytes) {
  silence_decoder();
  vtkNew<vtkDICOMReader> reader;
  silence(reader);
  silence(reader->GetExecutive());
  reader->SetFileName(file.c_str());
  reader->SortingOff();
  reader->TimeAsVectorOff();
  reader->AutoRescaleOff();
  reader->SetMemoryRowOrderToFileNative();
  reader->Update();
  vtkImageData* decoded = reader->GetOutput();
  const int* size = decoded->GetDimensions();
  const auto frames = static_cast<std::size_t>(image.layout.frames);
  if (reader->GetErrorCode() != 0 || size[0] != image.columns || size[1] != image.rows ||
      static_cast<std::size_t>(size[2]) != frames || decoded->GetNumberOfScalarComponents() != 1 ||
      !decoded->GetScalarPointer()) {
    return false;
  }
  const std::size_t at = pixels_at(frames);
  const std::size_t pixels = static_cast<std::size_t>(decoded->GetNumberOfPoints()) *
                             static_cast<std::size_t>(decoded->GetScalarSize());
  if (at + pixels > bytes) return false;
  const Head head{.type = decoded->GetScalarType()};
  auto* out = static_cast<std::byte*>(shared);
  std::memcpy(out, &head, sizeof head);
  std::memcpy(out + at, decoded->GetScalarPointer(), pixels);
  std::vector<int> slice_of_frame(frames, -1);
  vtkIntArray* frame_of_slice = reader->GetFrameIndexArray();
  for (int slice = 0; slice < size[2]; ++slice) {
    const int frame = frame_of_slice && slice < frame_of_slice->GetNumberOfValues()
                          ? frame_of_slice->GetValue(slice)
                          : slice;
    if (frame < 0 || frame >= size[2]) return false;
    slice_of_frame[static_cast<std::size_t>(frame)] = slice;
  }
  std::memcpy(out + sizeof head, slice_of_frame.data(), frames * sizeof(int));
  return true;
}

/// The same; a file that only lacks the mark behind its last fragment is read as if it had it.
bool decode(const DicomImage& image, void* shared, std::size_t bytes) {
  if (decode(image.file.string(), image, shared, bytes)) return true;
  constexpr std::string_view kMark("\xFE\xFF\xDD\xE0\0\0\0\0", 8);
  std::ifstream in(image.file, std::ios::binary);
  std::string content((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
  if (content.ends_with(kMark)) return false;
  content += kMark;
  const int memory = ::memfd_create("marked", MFD_CLOEXEC);
  if (memory < 0) return false;
  std::size_t done = 0;
  while (done < content.size()) {
    const ssize_t wrote = ::write(memory, content.data() + done, content.size() - done);
    if (wrote <= 0) break;
    done += static_cast<std::size_t>(wrote);
  }
  const bool good = done == content.size() &&
                    decode("/proc/self/fd/" + std::to_string(memory), image, shared, bytes);
  ::close(memory);
  return good;
}

}  // namespace

DecodedFile::DecodedFile(const DicomImage& image)
    : frames_(static_cast<std::size_t>(image.layout.frames)),
      frame_pixels_(static_cast<std::size_t>(image.rows) *
                    static_cast<std::size_t>(image.columns)) {
  if (!packed_frames_fit(image.file, image.layout.offset, image.columns, image.rows)) return;
  // Only what is written takes memory.
  bytes_ = pixels_at(frames_) + frames_ * frame_pixels_ * kWidest;
  void* const shared = ::mmap(nullptr, bytes_, PROT_READ | PROT_WRITE,
                              MAP_SHARED | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  if (shared == MAP_FAILED) return;
  shared_ = shared;
  good_ = done_apart([&] { return decode(image, shared_, bytes_); });
}

DecodedFile::~DecodedFile() {
  if (shared_) ::munmap(shared_, bytes_);
}

bool DecodedFile::read(int frame, std::span<float> out) const {
  if (!good_ || frame < 0 || static_cast<std::size_t>(frame) >= frames_) return false;
  if (out.size() != frame_pixels_) return false;
  const auto* from = static_cast<const std::byte*>(shared_);
  Head head{};
  std::memcpy(&head, from, sizeof head);
  int slice = 0;
  std::memcpy(&slice, from + sizeof head + static_cast<std::size_t>(frame) * sizeof slice,
              sizeof slice);
  if (slice < 0) return false;
  return as_float(head.type, from + pixels_at(frames_),
                  static_cast<std::size_t>(slice) * frame_pixels_, out);
}

}  // namespace beatlas::ingest
