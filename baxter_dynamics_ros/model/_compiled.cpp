// The closed form as a Python extension: checks of the arguments, batches without the GIL, and
// batches compiled for the instruction sets that a processor of this architecture may have.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include "_closed_form.h"

#define restrict __restrict__

namespace baseline {
#include "_closed_form.c"
}

#if defined(__x86_64__) && defined(__GNUC__) && !defined(BAXTER_DYNAMICS_BASELINE_ONLY)
#define BAXTER_DYNAMICS_X86 1
#define BAXTER_DYNAMICS_BATCHES_ONLY
#ifdef __clang__
#pragma clang attribute push(__attribute__((target("avx2,fma"))), apply_to = function)
#else
#pragma GCC push_options
#pragma GCC target("avx2,fma")
#endif
namespace avx2 {
#include "_closed_form.c"
}
#ifdef __clang__
#pragma clang attribute pop
#pragma clang attribute push(__attribute__((target("avx512f,avx512dq,fma"))), apply_to = function)
#else
#pragma GCC pop_options
#pragma GCC push_options
#pragma GCC target("avx512f,avx512dq,fma,prefer-vector-width=512")
#endif
namespace avx512 {
#include "_closed_form.c"
}
#ifdef __clang__
#pragma clang attribute pop
#else
#pragma GCC pop_options
#endif
#endif

namespace py = pybind11;

namespace {

using Parameters = baxter_dynamics_parameters;
using Inputs = std::array<const double *, 3>;
using Outputs = std::array<double *, 3>;
using One = void (*)(const Inputs &, const Parameters *, const Outputs &);
using Batch = void (*)(std::size_t, const Inputs &, const Parameters *, const Outputs &);

constexpr std::size_t kJoints = 7;
constexpr std::size_t kChunk = 512;  // states checked and computed at a time, within a cache

template <auto F, std::size_t... I, std::size_t... O>
void one(const Inputs &in, const Parameters *p, const Outputs &out, std::index_sequence<I...>,
         std::index_sequence<O...>) {
    F(in[I]..., p, out[O]...);
}

template <auto F, std::size_t I, std::size_t O>
void one(const Inputs &in, const Parameters *p, const Outputs &out) {
    one<F>(in, p, out, std::make_index_sequence<I>{}, std::make_index_sequence<O>{});
}

template <auto F, std::size_t... I, std::size_t... O>
void batch(std::size_t n, const Inputs &in, const Parameters *p, const Outputs &out,
           std::index_sequence<I...>, std::index_sequence<O...>) {
    F(n, in[I]..., p, out[O]...);
}

template <auto F, std::size_t I, std::size_t O>
void batch(std::size_t n, const Inputs &in, const Parameters *p, const Outputs &out) {
    batch<F>(n, in, p, out, std::make_index_sequence<I>{}, std::make_index_sequence<O>{});
}

struct Kernel {
    const char *name;
    One one;
    std::vector<Batch> batches;  // in the order of available()
};

#ifdef BAXTER_DYNAMICS_X86
#define BATCHES(name, inputs, outputs) \
    {&batch<baseline::baxter_dynamics_##name##_batch, inputs, outputs>, \
     &batch<avx2::baxter_dynamics_##name##_batch, inputs, outputs>, \
     &batch<avx512::baxter_dynamics_##name##_batch, inputs, outputs>}
#else
#define BATCHES(name, inputs, outputs) \
    {&batch<baseline::baxter_dynamics_##name##_batch, inputs, outputs>}
#endif
#define KERNEL(name, inputs, outputs) \
    {#name, &one<baseline::baxter_dynamics_##name, inputs, outputs>, BATCHES(name, inputs, outputs)},
const std::vector<Kernel> kKernels{BAXTER_DYNAMICS_FUNCTIONS(KERNEL)};

// Names of the targets that this processor has, the fastest last.
std::vector<std::string> available() {
    std::vector<std::string> names{"baseline"};
#ifdef BAXTER_DYNAMICS_X86
    __builtin_cpu_init();
    if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) {
        names.push_back("avx2");
        if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq"))
            names.push_back("avx512");
    }
#endif
    return names;
}

// Whether all numbers are finite: an exponent of ones plus one overflows into the sign bit.
bool all_finite(const double *x, std::size_t n) {
    std::uint64_t overflow = 0;
    for (std::size_t i = 0; i < n; i++) {
        std::uint64_t bits;
        std::memcpy(&bits, x + i, sizeof bits);
        overflow |= (bits & 0x7ff0000000000000u) + 0x0010000000000000u;
    }
    return !(overflow >> 63);
}

struct Function {
    One one;
    Batch batch;
    std::vector<std::string> names;
    std::vector<std::vector<py::ssize_t>> shapes;  // of one state's results
    std::vector<std::size_t> sizes;
    Parameters parameters;
    py::object validate;  // (names, arguments) -> contiguous float arrays of one shape, or raises
    py::dtype double_type = py::dtype::of<double>();
    py::object array_type = py::module_::import("numpy").attr("ndarray");

    py::object call(PyObject *const *arguments) const {
        std::array<py::array, 3> arrays;
        if (!direct(arguments, arrays))
            convert(arguments, arrays);
        bool finite;
        py::object results = compute(arrays, finite);
        if (!finite) {
            convert(arguments, arrays);  // raises, unless another thread has changed the numbers
            results = compute(arrays, finite);
        }
        return results;
    }

    // Take the arguments as they are if all are contiguous float arrays of one shape (..., 7).
    bool direct(PyObject *const *arguments, std::array<py::array, 3> &arrays) const {
        for (std::size_t i = 0; i < names.size(); i++) {
            if (reinterpret_cast<PyObject *>(Py_TYPE(arguments[i])) != array_type.ptr())
                return false;
            arrays[i] = py::reinterpret_borrow<py::array>(arguments[i]);
            const py::array &a = arrays[i];
            if (!usable(a) || a.ndim() != arrays[0].ndim()
                || !std::equal(a.shape(), a.shape() + a.ndim(), arrays[0].shape()))
                return false;
        }
        return true;
    }

    bool usable(const py::array &a) const {
        return a.ndim() > 0 && a.shape(a.ndim() - 1) == py::ssize_t(kJoints)
            && (a.flags() & py::array::c_style) && a.dtype().is(double_type)
            && reinterpret_cast<std::uintptr_t>(a.data()) % alignof(double) == 0;
    }

    void convert(PyObject *const *arguments, std::array<py::array, 3> &arrays) const {
        py::tuple values(names.size());
        for (std::size_t i = 0; i < names.size(); i++)
            values[i] = py::reinterpret_borrow<py::object>(arguments[i]);
        const py::list valid = validate(names, values);
        for (std::size_t i = 0; i < names.size(); i++)
            arrays[i] = valid[i].cast<py::array>();
    }

    py::object compute(const std::array<py::array, 3> &arrays, bool &finite) const {
        const std::size_t n = std::size_t(arrays[0].size()) / kJoints;
        Inputs in{};
        Outputs out{};
        for (std::size_t i = 0; i < names.size(); i++)
            in[i] = static_cast<const double *>(arrays[i].data());
        std::array<py::object, 3> results;
        for (std::size_t i = 0; i < shapes.size(); i++) {
            std::vector<py::ssize_t> shape(arrays[0].shape(),
                                           arrays[0].shape() + arrays[0].ndim() - 1);
            shape.insert(shape.end(), shapes[i].begin(), shapes[i].end());
            py::array_t<double> result(std::move(shape));
            out[i] = result.mutable_data();
            results[i] = std::move(result);
        }
        if (n == 1) {
            finite = all_inputs_finite(in, 1);
            if (finite)
                one(in, &parameters, out);
        } else {
            py::gil_scoped_release release;
            finite = compute_many(n, in, out);
        }
        if (shapes.size() == 1)
            return std::move(results[0]);
        py::tuple all(shapes.size());
        for (std::size_t i = 0; i < shapes.size(); i++)
            all[i] = std::move(results[i]);
        return all;
    }

    bool compute_many(std::size_t n, Inputs in, Outputs out) const {
        for (std::size_t start = 0; start < n; start += kChunk) {
            const std::size_t m = std::min(kChunk, n - start);
            if (!all_inputs_finite(in, m))
                return false;
            batch(m, in, &parameters, out);
            for (std::size_t i = 0; i < names.size(); i++)
                in[i] += kJoints * m;
            for (std::size_t i = 0; i < shapes.size(); i++)
                out[i] += sizes[i] * m;
        }
        return true;
    }

    bool all_inputs_finite(const Inputs &in, std::size_t n) const {
        for (std::size_t i = 0; i < names.size(); i++)
            if (!all_finite(in[i], kJoints * n))
                return false;
        return true;
    }
};

PyObject *call(PyObject *self, PyObject *const *arguments, Py_ssize_t count) {
    const auto *function = static_cast<const Function *>(PyCapsule_GetPointer(self, nullptr));
    if (std::size_t(count) != function->names.size()) {
        PyErr_Format(PyExc_TypeError, "expected %zu arguments, got %zd", function->names.size(),
                     count);
        return nullptr;
    }
    try {
        return function->call(arguments).release().ptr();
    } catch (py::error_already_set &error) {
        error.restore();
    } catch (const std::exception &error) {
        PyErr_SetString(PyExc_RuntimeError, error.what());
    }
    return nullptr;
}

PyMethodDef kCall{"function", reinterpret_cast<PyCFunction>(reinterpret_cast<void (*)()>(call)),
                  METH_FASTCALL, nullptr};

// A builtin function rather than an object of pybind11: its calls cost 0.2 us less.
py::object make(const std::string &name, std::vector<std::string> names,
                std::vector<std::vector<py::ssize_t>> shapes,
                const std::vector<double> &parameters, py::object validate, std::string target) {
    const auto targets = available();
    if (target.empty())
        target = targets.back();
    const auto index = std::find(targets.begin(), targets.end(), target) - targets.begin();
    if (std::size_t(index) == targets.size())
        throw py::value_error("target: not available on this processor: " + target);
    const auto kernel = std::find_if(kKernels.begin(), kKernels.end(), [&](const Kernel &each) {
        return name == each.name;
    });
    if (kernel == kKernels.end() || parameters.size() * sizeof(double) != sizeof(Parameters))
        throw py::value_error("the extension does not fit _closed_form.py: build it again");
    auto function = std::make_unique<Function>();
    function->one = kernel->one;
    function->batch = kernel->batches[std::size_t(index)];
    function->names = std::move(names);
    for (const auto &shape : shapes) {
        std::size_t size = 1;
        for (const auto length : shape)
            size *= std::size_t(length);
        function->sizes.push_back(size);
    }
    function->shapes = std::move(shapes);
    std::memcpy(&function->parameters, parameters.data(), sizeof(Parameters));
    function->validate = std::move(validate);
    py::capsule self(function.get(), [](void *pointer) { delete static_cast<Function *>(pointer); });
    function.release();
    return py::reinterpret_steal<py::object>(PyCFunction_NewEx(&kCall, self.ptr(), nullptr));
}

}  // namespace

PYBIND11_MODULE(_compiled, module) {
    module.attr("TARGETS") = py::tuple(py::cast(available()));
    module.def("function", &make, py::arg("name"), py::arg("names"), py::arg("shapes"),
               py::arg("parameters"), py::arg("validate"), py::arg("target") = "",
               "Return a function of the closed form, whose arguments are validated.");
}
