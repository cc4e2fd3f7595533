#!/usr/bin/env bash
# Installs what building and testing need on Debian 12: only what is missing, and nothing otherwise. As root or with sudo.
set -euo pipefail

# OpenBLAS because Debian's default BLAS is the reference one, several times slower in 3D.
packages=(
  gcc libc6-dev make cmake pkg-config check ccache
  petsc-dev libhypre-dev libmumps-dev libmetis-dev liblapack-dev libhdf5-openmpi-dev libyaml-dev libopenmpi-dev openmpi-bin libopenblas0-serial
  libembree-dev
  python3 python3-numpy python3-h5py python3-yaml python3-matplotlib python3-jsonschema mandoc
  python3-sphinx python3-myst-parser furo python3-pil
  dpkg-dev file lintian locales
  python3-pandas python3-scipy python3-pip python3-venv python3-nbclient python3-ipykernel python3-meshio mypy
  python3-ezdxf python3-gdal python3-shapely
)

if ! command -v apt-get >/dev/null; then
  echo "setup: this is not Debian; install these packages' counterparts by hand: ${packages[*]}" >&2
  exit 1
fi

missing=()
for package in "${packages[@]}"; do
  [[ "$(dpkg-query -W -f='${db:Status-Status}\n' "$package" 2>/dev/null)" == *installed* ]] || missing+=("$package")
done
if ((${#missing[@]} == 0)); then
  echo "setup: all ${#packages[@]} packages are installed"
  exit 0
fi

as_root=()
if ((EUID != 0)); then
  if ! command -v sudo >/dev/null; then
    echo "setup: run it as root, or install sudo; missing are ${missing[*]}" >&2
    exit 1
  fi
  as_root=(sudo)
fi
echo "setup: installing ${missing[*]}"
"${as_root[@]}" apt-get update -qq
"${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "${missing[@]}" >/dev/null
