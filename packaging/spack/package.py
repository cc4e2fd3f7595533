"""Recipe for Spack. `spack repo create` makes a repository; this file goes to packages/talus/ of it, and `spack dev-build
talus@main` in a clone of the sources builds it.

Checked: that it is Python, and that the options of CMake are those of CMakeLists.txt (tests/regression/test_packages.py). Not
run with Spack.
"""
from spack.package import CMakePackage, depends_on, license, variant, version


class Talus(CMakePackage):
    """Implicit material point method for geomechanics, on PETSc."""

    license("BSD-2-Clause")
    version("main", branch="main")

    variant("native", default=True, description="compile for the processor that compiles")
    variant("stl", default=True, description="boundaries from STL files, by Embree")
    variant("python", default=True, description="what pictures and checks of examples need")

    depends_on("c", type="build")
    depends_on("cmake@3.20:", type="build")
    depends_on("pkgconfig", type="build")
    depends_on("check", type=("build", "link"))
    depends_on("mpi")
    depends_on("lapack")
    depends_on("petsc@3.18:3.25~complex+mpi+mumps+hypre+metis")
    depends_on("hdf5+mpi")
    depends_on("libyaml")
    depends_on("embree@3:4", when="+stl")
    depends_on("python@3.10:", type=("build", "run"))
    for package in ("py-numpy", "py-h5py", "py-pyyaml", "py-matplotlib", "py-pillow"):
        depends_on(package, type="run", when="+python")

    def cmake_args(self):
        """Options of CMake."""
        return [self.define_from_variant("TALUS_NATIVE", "native"), self.define("TALUS_TESTS", self.run_tests),
                self.define("PETSC_DIR", self.spec["petsc"].prefix)]
