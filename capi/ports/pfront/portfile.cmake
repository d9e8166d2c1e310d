# A port for vcpkg, as an overlay: vcpkg install pfront --overlay-ports=capi/ports. It builds the checkout that it lies in, by the
# cargo of this machine, since vcpkg has no Rust.
get_filename_component(source "${CMAKE_CURRENT_LIST_DIR}/../.." ABSOLUTE)
find_program(CARGO cargo
  PATHS "$ENV{CARGO_HOME}/bin" "$ENV{USERPROFILE}/.cargo/bin" "$ENV{HOME}/.cargo/bin"
  REQUIRED)
if(VCPKG_TARGET_IS_WINDOWS AND VCPKG_CRT_LINKAGE STREQUAL "static")
  set(ENV{RUSTFLAGS} "-C target-feature=+crt-static")
endif()
vcpkg_check_features(OUT_FEATURE_OPTIONS options
  FEATURES
    threads PFRONT_THREADS
    gpu PFRONT_GPU)
vcpkg_cmake_configure(SOURCE_PATH "${source}" OPTIONS ${options} "-DCARGO=${CARGO}")
vcpkg_cmake_install()
vcpkg_cmake_config_fixup(PACKAGE_NAME pfront CONFIG_PATH lib/cmake/pfront)
vcpkg_fixup_pkgconfig()
file(REMOVE_RECURSE "${CURRENT_PACKAGES_DIR}/debug/include")
vcpkg_install_copyright(FILE_LIST "${source}/../LICENSE-MIT" "${source}/../LICENSE-APACHE")
