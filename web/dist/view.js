// The page is not built yet: npm run build in web/.
