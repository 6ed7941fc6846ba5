# Writes a C++ file that tells the SHA-256 of files, names and contents:
# cmake -D OUT=sources_hash.cpp -D ROOT=the_project -D LIST=names.txt -P sources_hash.cmake
file(READ "${LIST}" files)
if(files STREQUAL "")
  message(FATAL_ERROR "${LIST} names no files")
endif()
set(all "")
foreach(file IN LISTS files)
  file(SHA256 "${ROOT}/${file}" hash)
  string(APPEND all "${hash} ${file}\n")
endforeach()
string(SHA256 hash "${all}")
file(WRITE "${OUT}" "#include \"pipeline/build/version.h\"\n
namespace beatlas::build {\n
const char* sources_sha256() noexcept { return \"${hash}\"; }\n
}  // namespace beatlas::build\n")
