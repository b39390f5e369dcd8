//! Memory of images and of golden cases. `firmware` has it too: an image that links this crate has other code.

/// A structure whose constant `new()` has the first value beside each field.
#[macro_export]
macro_rules! arrays {
    ($(#[$about:meta])* $seen:vis struct $name:ident {
        $($(#[$of:meta])* $field:ident: $type:ty = $first:expr,)*
    }) => {
        $(#[$about])*
        $seen struct $name {
            $($(#[$of])* $field: $type,)*
        }

        impl $name {
            /// The first values.
            $seen const fn new() -> Self {
                $name { $($field: $first,)* }
            }
        }

        impl Default for $name {
            fn default() -> Self {
                Self::new()
            }
        }
    };
}
