//! Indices into the scene's tables.

macro_rules! id {
    ($(#[$doc:meta])* $name:ident) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
        pub struct $name(pub u32);

        impl $name {
            pub fn index(self) -> usize {
                self.0 as usize
            }
        }
    };
}

id!(
    /// An object; the geometry id that ray backends return.
    ObjectId
);
id!(
    /// A triangle mesh, shared by its instances.
    MeshId
);
id!(
    /// A material.
    MaterialId
);
id!(
    /// A participating medium.
    MediumId
);
id!(
    /// An image texture.
    TextureId
);
id!(
    /// A light source.
    LightId
);
